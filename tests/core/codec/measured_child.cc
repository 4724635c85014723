#include "tests/core/codec/measured_child.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <exception>

namespace cagefit::testing {
namespace {

constexpr int kCpuSeconds = 20;
constexpr int kUncaughtException = 255;

double Milliseconds(const timeval& time) { return 1e3 * time.tv_sec + 1e-3 * time.tv_usec; }

}  // namespace

ChildReport RunInChild(const std::function<int()>& body) {
  const pid_t child = fork();
  if (child == 0) {
    const rlimit limit = {kCpuSeconds, kCpuSeconds};
    setrlimit(RLIMIT_CPU, &limit);
    int code = kUncaughtException;
    try {
      code = body();
    } catch (const std::exception&) {
    }
    _exit(code);
  }
  ChildReport report;
  int status = 0;
  rusage usage = {};
  if (child < 0 || wait4(child, &status, 0, &usage) != child) return report;
  if (WIFEXITED(status)) report.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) report.signal = WTERMSIG(status);
  report.cpu_ms = Milliseconds(usage.ru_utime) + Milliseconds(usage.ru_stime);
  report.peak_mib = static_cast<double>(usage.ru_maxrss) / 1024;
  return report;
}

}  // namespace cagefit::testing
