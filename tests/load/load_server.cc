#include "tests/load/load_server.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace cagefit::testing {

int64_t ResidentBytes(pid_t process) {
  std::ifstream file(absl::StrCat("/proc/", process, "/statm"));
  int64_t pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

LoadServer::LoadServer(const std::vector<std::string>& arguments)
    : server_(arguments), watch_([this] {
        while (!ending_) {
          const int64_t now = resident_bytes();
          peak_ = std::max<int64_t>(peak_, now);
          absl::SleepFor(absl::Milliseconds(5));
        }
      }) {}

double LoadServer::cpu_ms() {
  std::ifstream file(absl::StrCat("/proc/", server_.program().pid(), "/stat"));
  std::string field;
  int64_t user = 0, system = 0;
  for (int k = 1; k < 14; ++k) file >> field;  // none of them, our name included, has a space
  file >> user >> system;
  return 1e3 * static_cast<double>(user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

LoadServer::~LoadServer() {
  ending_ = true;
  watch_.join();
}

}  // namespace cagefit::testing
