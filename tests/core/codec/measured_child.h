// Runs code in a child process and says what it cost: a crash or a hang fails one test only.
#ifndef CAGEFIT_TESTS_CORE_CODEC_MEASURED_CHILD_H_
#define CAGEFIT_TESTS_CORE_CODEC_MEASURED_CHILD_H_

#include <functional>

namespace cagefit::testing {

struct ChildReport {
  int exit_code = -1;  // what `body` returned, or -1 after a signal
  int signal = 0;      // 9 or 24 after more than 20 s of processor time
  double cpu_ms = 0;
  double peak_mib = 0;  // resident; of no meaning under a sanitizer
};

// `body` returns 0 to 255.
ChildReport RunInChild(const std::function<int()>& body);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_CODEC_MEASURED_CHILD_H_
