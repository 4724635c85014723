// The real server as a load program sees it from outside.
#ifndef CAGEFIT_TESTS_LOAD_LOAD_SERVER_H_
#define CAGEFIT_TESTS_LOAD_LOAD_SERVER_H_

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "tests/e2e/program.h"
#include "tests/support/sanitizer.h"

namespace cagefit::testing {

// Resident memory of a process now.
int64_t ResidentBytes(pid_t process);

// cagefitd on a free port, whose memory is looked at all the time.
class LoadServer {
 public:
  explicit LoadServer(const std::vector<std::string>& arguments);
  ~LoadServer();

  const std::string& address() const { return server_.address(); }
  double cpu_ms();  // that it has used
  int64_t resident_bytes() { return ResidentBytes(server_.program().pid()); }
  // The most since the start, or since ForgetPeak.
  int64_t peak_bytes() const { return peak_; }
  // Whether it never had more; with a sanitizer, times what that costs.
  bool HasStayedBelow(int64_t bytes) const {
    return static_cast<double>(peak_bytes()) <= kCostFactor * static_cast<double>(bytes);
  }
  void ForgetPeak() { peak_ = 0; }

 private:
  ServerProgram server_;
  std::atomic<int64_t> peak_{0};
  std::atomic<bool> ending_{false};
  std::thread watch_;
};

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_LOAD_LOAD_SERVER_H_
