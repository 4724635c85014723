// Runs the programs that were built.
#ifndef CAGEFIT_TESTS_E2E_PROGRAM_H_
#define CAGEFIT_TESTS_E2E_PROGRAM_H_

#include <sys/types.h>

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace cagefit::testing {

struct ProgramResult {
  int exit_code = -1;  // -1: ended by a signal
  std::string out, err;
};

// `cagefit` with these arguments. `environment` holds NAME=VALUE entries beside this process's own.
ProgramResult RunCagefit(const std::vector<std::string>& arguments,
                         const std::vector<std::string>& environment = {});

std::string CagefitProgram();

// A process that runs beside the test. Ended with SIGKILL when destroyed.
class RunningProgram {
 public:
  RunningProgram(const std::string& program, const std::vector<std::string>& arguments);
  ~RunningProgram();
  RunningProgram(const RunningProgram&) = delete;
  RunningProgram& operator=(const RunningProgram&) = delete;

  // The next line of its standard output; empty at the end.
  std::string ReadLine();
  void Signal(int signal) const;
  pid_t pid() const { return pid_; }
  // Waits for its end; the exit code, or -1 when a signal ended it.
  int Wait();
  // Its largest resident memory so far.
  int64_t PeakMiB() const;
  // The time that all its threads have worked.
  double CpuSeconds() const;

 private:
  pid_t pid_ = -1;
  int out_ = -1;
};

// cagefitd on a free port, with its sessions in memory, unless the arguments say otherwise.
class ServerProgram {
 public:
  explicit ServerProgram(const std::vector<std::string>& arguments = {});
  const std::string& address() const { return address_; }
  RunningProgram& program() { return program_; }

 private:
  RunningProgram program_;
  std::string address_;
};

// A new folder of the running test's own, empty.
std::string EmptyFolder(const std::string& name);
std::string ReadText(const std::string& path);
void WriteText(const std::string& path, const std::string& text);
nlohmann::json ReadJson(const std::string& path);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_E2E_PROGRAM_H_
