#include <iostream>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "client/commands/command.h"
#include "client/commands/credential_flags.h"
#include "client/commands/json.h"
#include "client/fit_client.h"

namespace cagefit::client {
namespace {

struct HealthArguments {
  std::string server = "127.0.0.1:50051", service = "cagefit.v1.Fitting";
  double timeout_seconds = 5;
  bool json = false;
  ClientCredentials credentials;
};

struct Answer {
  const char* word;
  ExitCode exit_code;
};

Answer AnswerOf(const absl::StatusOr<bool>& serving) {
  if (serving.ok()) return *serving ? Answer{"serving", kDone} : Answer{"not-serving", kFailed};
  if (absl::IsNotFound(serving.status())) return {"unknown-service", kFailed};
  // A server that does not answer in time is none for who asks.
  const bool none =
      absl::IsUnavailable(serving.status()) || absl::IsDeadlineExceeded(serving.status());
  return none ? Answer{"no-server", kNoServer} : Answer{"error", kFailed};
}

int CheckHealth(const HealthArguments& arguments) {
  const absl::Duration timeout = absl::Seconds(arguments.timeout_seconds);
  const auto client = FitClient::Connect({arguments.server, timeout, arguments.credentials});
  const absl::StatusOr<bool> serving =
      client.ok() ? (*client)->IsServing(arguments.service, timeout) : client.status();
  const Answer answer = AnswerOf(serving);
  if (arguments.json) {
    std::cout << Json{{"server", arguments.server},
                      {"service", arguments.service},
                      {"health", answer.word},
                      {"message", std::string(serving.status().message())}}
                     .dump()
              << "\n";
  } else {
    std::cout << answer.word << "\n";
    if (!serving.ok()) Report(serving.status());
  }
  return answer.exit_code;
}

}  // namespace

void AddHealthCommand(CLI::App* app, Run* run) {
  const auto arguments = std::make_shared<HealthArguments>();
  CLI::App* command = app->add_subcommand(
      "health",
      "Ask a server whether it is ready: exit code 0 if so, 1 if not, 3 without a server");
  command->add_option("--server", arguments->server, "HOST:PORT or unix:PATH")
      ->capture_default_str();
  command
      ->add_option("--service", arguments->service,
                   "Ready for work, or \"\": whether the process is alive")
      ->capture_default_str();
  command->add_option("--timeout", arguments->timeout_seconds, "Seconds to wait for an answer")
      ->check(CLI::Range(0.01, 3600.0))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "Print JSON");
  AddCredentialFlags(&arguments->credentials, command);
  command->callback([arguments, run] { *run = [arguments] { return CheckHealth(*arguments); }; });
}

}  // namespace cagefit::client
