#include "server/process_memory.h"

#include <malloc.h>
#include <unistd.h>

#include <fstream>

#include "absl/time/clock.h"

namespace cagefit::server {

int64_t ResidentBytes() {
  int64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages >> pages;  // size, then what is resident
  return pages * sysconf(_SC_PAGESIZE);
}

void SetUpAllocator() {
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  mallopt(M_ARENA_MAX, 4);
}

bool ResidentLimit::MakeRoom(int64_t bytes) {
  const absl::Time start = absl::Now();
  if (ResidentBytes() + bytes <= limit_) return false;
  const std::unique_lock<std::mutex> lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock() || start < next_) return false;
  malloc_trim(0);
  const absl::Time end = absl::Now();
  next_ = end + 9 * (end - start);
  return true;
}

}  // namespace cagefit::server
