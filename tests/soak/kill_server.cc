// Kills the server over and over while a client streams, and checks what the client saw.
//
//   kill_server [--kills 500] [--seed 1] [--server cagefitd] [--postgres | -- --store ...]
#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <iostream>
#include <optional>
#include <random>
#include <thread>

#include "absl/time/clock.h"
#include "core/base/status.h"
#include "tests/soak/resume.h"
#include "tests/soak/sequence.h"
#include "tests/soak/soak_server.h"
#include "tests/soak/verdict.h"
#include "tests/support/postgres_server.h"

namespace cagefit::testing {
namespace {

struct Options {
  int kills = 500;
  uint64_t seed = 1;
  uint64_t frames = 200;  // of a session; as many sessions as the kills take
  double restart_seconds = 2;
  bool postgres = false;  // a store of its own
  std::string server;
  std::vector<std::string> server_arguments;
};

// One session under kills.
class Session {
 public:
  Session(const Options& options, SoakServer* server, std::mt19937_64* random)
      : options_(options), server_(*server), random_(*random) {}

  // Kills at most `kills` times; returns how often.
  absl::StatusOr<int> Run(int kills, absl::Duration* slowest) {
    ASSIGN_OR_RETURN(const auto client, client::FitClient::Connect({server_.address()}));
    ASSIGN_OR_RETURN(const v1::Session session, client->CreateSession(SoakSession()));
    Resumption run;
    run.address = server_.address();
    run.session_id = session.session_id();
    run.frames = options_.frames;
    run.seen = [this](const History::Event& event) { See(event); };
    absl::Status streamed;
    std::thread streaming([&] {
      streamed = StreamToEnd(run);
      done_ = true;
    });
    int killed = 0;
    absl::Status status;
    while (status.ok() && killed < kills && WaitForAnswers(1 + random_() % 6)) {
      absl::SleepFor(absl::Microseconds(random_() % 8000));
      if (done_) break;
      status = KillAndRestart(slowest);
      ++killed;
    }
    streaming.join();
    RETURN_IF_ERROR(status);
    RETURN_IF_ERROR(streamed);
    RETURN_IF_ERROR(CheckStored(session.session_id(), options_.frames, server_.address()));
    return killed;
  }

  const History& history() const { return history_; }

 private:
  void See(const History::Event& event) {
    history_.Add(event);
    if (event.kind == History::Event::Kind::kOpened) {
      answers_ = 0;
      ++streams_;
    }
    if (event.kind == History::Event::Kind::kAnswered) ++answers_;
  }

  // False when the session ends, or waits in vain, before its stream has answered so often.
  bool WaitForAnswers(uint64_t count, uint64_t streams = 0) {
    const absl::Time deadline = absl::Now() + absl::Minutes(1);
    while (streams_ < streams || answers_ < count) {
      if (done_ || absl::Now() > deadline) return false;
      absl::SleepFor(absl::Microseconds(200));
    }
    return true;
  }

  // And waits for an answer of the next stream, so that no frame meets two kills without progress
  // between them.
  absl::Status KillAndRestart(absl::Duration* slowest) {
    const uint64_t streams = streams_;
    server_.Kill();
    const absl::Time start = absl::Now();
    RETURN_IF_ERROR(server_.Start());
    const bool answered = WaitForAnswers(1, streams + 1);
    const absl::Duration took = absl::Now() - start;
    if (!answered && done_) return absl::OkStatus();
    *slowest = std::max(*slowest, took);
    if (answered && took <= absl::Seconds(options_.restart_seconds)) return absl::OkStatus();
    return absl::DeadlineExceededError("the first new answer came " + absl::FormatDuration(took) +
                                       " after the restart");
  }

  const Options& options_;
  SoakServer& server_;
  std::mt19937_64& random_;
  History history_;
  std::atomic<uint64_t> streams_{0}, answers_{0};  // opened; of the latest of them
  std::atomic<bool> done_{false};
};

absl::Status Run(const Options& options) {
  std::mt19937_64 random(options.seed);
  std::optional<PostgresServer> postgres;
  std::vector<std::string> arguments = options.server_arguments;
  if (options.postgres) {
    arguments.insert(arguments.end(), {"--store", "postgres:" + postgres.emplace().NewDatabase()});
  }
  SoakServer server(options.server, arguments);
  RETURN_IF_ERROR(server.Start());
  ASSIGN_OR_RETURN(const auto undisturbed, UndisturbedBits(options.frames));
  absl::Duration slowest;
  int killed = 0, sessions = 0;
  for (; killed < options.kills; ++sessions) {
    Session session(options, &server, &random);
    ASSIGN_OR_RETURN(const int more, session.Run(options.kills - killed, &slowest));
    killed += more;
    RETURN_IF_ERROR(Judge(session.history(), undisturbed));
  }
  std::cout << killed << " kills, " << sessions << " sessions of " << options.frames
            << " frames: each answered once, in order, equal to the bit; first new answer after "
            << absl::FormatDuration(slowest) << " at most\n";
  return absl::OkStatus();
}

}  // namespace
}  // namespace cagefit::testing

int main(int argc, char** argv) {
  cagefit::testing::Options options;
  options.server = cagefit::testing::ProgramBeside("cagefitd");
  CLI::App app("Kills the server over and over while a client streams.");
  app.add_option("--kills", options.kills)->capture_default_str();
  app.add_option("--seed", options.seed)->capture_default_str();
  app.add_option("--frames", options.frames, "Of a session")->capture_default_str();
  app.add_option("--restart-seconds", options.restart_seconds, "Until the first new answer")
      ->capture_default_str();
  app.add_flag("--postgres", options.postgres, "Keep sessions in a PostgreSQL of its own");
  app.add_option("--server", options.server)->capture_default_str();
  app.add_option("server_arguments", options.server_arguments, "Behind --");
  CLI11_PARSE(app, argc, argv);
  return cagefit::testing::Report(cagefit::testing::Run(options), argc, argv);
}
