// cagefitd: serves until SIGTERM or SIGINT, then drains; a second signal ends it at once.
#include <errno.h>
#include <google/protobuf/stubs/logging.h>
#include <semaphore.h>
#include <signal.h>

#include <cstdlib>
#include <cstring>
#include <exception>
#include <iostream>
#include <memory>
#include <thread>

#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "server/log.h"
#include "server/process_memory.h"
#include "server/server.h"
#include "server/server_options.h"

namespace cagefit::server {
namespace {

// Threads that libraries start before main would take a signal that is only blocked here, and die
// of it: so there is a handler, which any thread may run.
sem_t signals_seen;
volatile sig_atomic_t last_signal = 0;

void OnSignal(int signal) {
  last_signal = signal;
  sem_post(&signals_seen);
}

void HandleEndSignals() {
  sem_init(&signals_seen, 0, 0);
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  action.sa_flags = SA_RESTART;
  for (const int number : {SIGTERM, SIGINT}) sigaction(number, &action, nullptr);
}

int WaitForSignal() {
  while (sem_wait(&signals_seen) != 0) {
  }
  return last_signal;
}

// What cannot be cancelled, such as a solver's step on a large mesh, gets this much after the
// drain.
constexpr absl::Duration kGrace = absl::Milliseconds(700);

// Ends the process at a second signal, or when it has not ended by itself after `drain`.
void EndAnyway(absl::Duration drain, const std::shared_ptr<spdlog::logger>& log) {
  std::thread([log, end = absl::ToTimespec(absl::Now() + drain + kGrace)] {
    int waited = 0;
    do {
      waited = sem_timedwait(&signals_seen, &end);
    } while (waited != 0 && errno == EINTR);
    log->warn(waited == 0 ? "ended cause=signal" : "ended cause=deadline");
    absl::SleepFor(absl::Milliseconds(20));  // for that line, if standard error takes it
    std::_Exit(EXIT_FAILURE);
  }).detach();
}

int Run(const ServerOptions& options) {
  HandleEndSignals();
  signal(SIGPIPE, SIG_IGN);
  const ConsoleLog console(options.log_level, options.log_format);
  const std::shared_ptr<spdlog::logger> log = console.logger();
  auto server = Server::Start(options, log);
  if (!server.ok()) {
    std::cerr << "cagefitd: " << server.status().message() << "\n";
    return EXIT_FAILURE;
  }
  // Flushed, and on standard output: what starts this program reads the port from it.
  for (const std::string& address : (*server)->addresses()) {
    std::cout << "listening on " << address << std::endl;
  }
  for (const std::string& address : (*server)->health_addresses()) {
    std::cout << "health on " << address << std::endl;
  }
  if (const auto address = (*server)->metrics_address()) {
    std::cout << "metrics on " << *address << std::endl;
  }
  log->info("serving");
  const int first = WaitForSignal();
  const absl::Duration delay = absl::Seconds(options.drain_delay);
  const absl::Duration drain = absl::Seconds(options.drain_seconds);
  log->info("draining signal={} delay={} seconds={}", strsignal(first), options.drain_delay,
            options.drain_seconds);
  EndAnyway(delay + drain, log);
  (*server)->StopBeingReady();
  absl::SleepFor(delay);
  (*server)->Shutdown(drain);
  server->reset();
  log->info("ended");
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace cagefit::server

int main(int argc, char** argv) try {
  cagefit::server::SetUpAllocator();
  // gRPC writes to standard error for itself; what matters comes as a status.
  setenv("GRPC_VERBOSITY", "NONE", /*overwrite=*/0);
  // Nor may a client write there, line by line, with strings that are not UTF-8.
  google::protobuf::SetLogHandler(nullptr);
  const cagefit::server::ParsedServerOptions parsed =
      cagefit::server::ParseServerOptions(argc, argv);
  if (parsed.exit_code.has_value()) return *parsed.exit_code;
  return cagefit::server::Run(parsed.options);
} catch (const std::exception& error) {
  std::cerr << "cagefitd: " << error.what() << "\n";
  return EXIT_FAILURE;
}
