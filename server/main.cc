// cagefitd: serves until SIGTERM or SIGINT, then drains; a second signal ends it at once.
#include <signal.h>

#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <memory>
#include <thread>

#include "absl/time/time.h"
#include "server/log.h"
#include "server/server.h"
#include "server/server_options.h"

namespace cagefit::server {
namespace {

// Signals are taken by the thread that asks for them, so every thread has to block them.
sigset_t BlockEndSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

int WaitForSignal(const sigset_t& signals) {
  int signal = 0;
  sigwait(&signals, &signal);
  return signal;
}

int Run(const ServerOptions& options) {
  const sigset_t signals = BlockEndSignals();
  signal(SIGPIPE, SIG_IGN);
  const std::shared_ptr<spdlog::logger> log = ConsoleLog(options.log_level);
  auto server = Server::Start(options, log);
  if (!server.ok()) {
    std::cerr << "cagefitd: " << server.status().message() << "\n";
    return EXIT_FAILURE;
  }
  // Flushed, and on standard output: what starts this program reads the port from it.
  for (const std::string& address : (*server)->addresses()) {
    std::cout << "listening on " << address << std::endl;
  }
  log->info("serving");
  const int first = WaitForSignal(signals);
  log->info("draining signal={} seconds={}", strsignal(first), options.drain_seconds);
  std::thread([signals] {
    WaitForSignal(signals);
    std::_Exit(EXIT_FAILURE);
  }).detach();
  (*server)->Shutdown(absl::Seconds(options.drain_seconds));
  server->reset();
  log->info("ended");
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace cagefit::server

int main(int argc, char** argv) try {
  const cagefit::server::ParsedServerOptions parsed =
      cagefit::server::ParseServerOptions(argc, argv);
  if (parsed.exit_code.has_value()) return *parsed.exit_code;
  return cagefit::server::Run(parsed.options);
} catch (const std::exception& error) {
  std::cerr << "cagefitd: " << error.what() << "\n";
  return EXIT_FAILURE;
}
