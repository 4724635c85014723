// A real server that is ended and started again at the same address.
#ifndef CAGEFIT_TESTS_SOAK_SOAK_SERVER_H_
#define CAGEFIT_TESTS_SOAK_SOAK_SERVER_H_

#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tests/e2e/program.h"

namespace cagefit::testing {

class SoakServer {
 public:
  // `program` with `arguments` beside the address, and its sessions in memory unless these name a
  // store. Start does not run it yet.
  SoakServer(std::string program, std::vector<std::string> arguments);
  // Kills it, and removes the folder of its socket.
  ~SoakServer();

  const std::string& address() const { return address_; }

  // Returns when it listens. UNAVAILABLE when it ends before.
  absl::Status Start();
  int Terminate();            // SIGTERM; its exit code, when it is gone
  void Kill();                // SIGKILL; returns when it is gone
  double CpuSeconds() const;  // of all cores, since Start

 private:
  const std::string program_;
  const std::string folder_;
  const std::string address_;
  std::vector<std::string> arguments_;
  std::unique_ptr<RunningProgram> running_;
};

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SOAK_SOAK_SERVER_H_
