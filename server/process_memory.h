// What this process has of the machine's memory, and how its allocator gives that back.
#ifndef CAGEFIT_SERVER_PROCESS_MEMORY_H_
#define CAGEFIT_SERVER_PROCESS_MEMORY_H_

#include <cstdint>
#include <mutex>

#include "absl/time/time.h"

namespace cagefit::server {

// Resident now, as the system counts.
int64_t ResidentBytes();

// Before the process has threads. Large blocks that are freed go back to the machine one by one,
// all others lie in few arenas: by default the C library keeps what each of many threads has used.
void SetUpAllocator();

// Freed blocks between used ones stay resident, in a loaded server as much as all that is used.
// This gives their pages back before the process comes to have more than a limit. Thread-safe.
class ResidentLimit {
 public:
  explicit ResidentLimit(int64_t bytes) : limit_(bytes) {}

  // To be called before `bytes` are allocated. Returns whether pages were given back: not while
  // another thread does so, nor so often that it would take more than a tenth of the time.
  bool MakeRoom(int64_t bytes);

 private:
  const int64_t limit_;
  std::mutex mutex_;
  absl::Time next_ = absl::InfinitePast();
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_PROCESS_MEMORY_H_
