// Kills the client over and over while it streams; each new one goes on behind the answers that
// the ones before it wrote down.
//
//   kill_client [--kills 500] [--seed 1] [--server cagefitd] -- SERVER ARGUMENTS
#include <signal.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <random>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "core/base/status.h"
#include "tests/soak/event_line.h"
#include "tests/soak/resume.h"
#include "tests/soak/sequence.h"
#include "tests/soak/soak_server.h"
#include "tests/soak/verdict.h"

namespace cagefit::testing {
namespace {

struct Options {
  int kills = 500;
  uint64_t seed = 1;
  uint64_t frames = 200;  // of a session; as many sessions as the kills take
  std::string server;
  std::vector<std::string> server_arguments;
  // Of a client: what it is to stream, and where.
  std::string address, session_id;
  uint64_t first = 0;
};

absl::Status RunClient(const Options& options) {
  Resumption run;
  run.address = options.address;
  run.session_id = options.session_id;
  run.first = options.first;
  run.frames = options.frames;
  run.seen = [](const History::Event& event) { std::cout << LineOf(event) << std::endl; };
  return StreamToEnd(run);
}

// Reads a client's lines into `history` until it has answered more than `answers` frames, or ends;
// returns how many.
uint64_t ReadAnswers(RunningProgram* client, uint64_t answers, History* history) {
  uint64_t read = 0;
  while (read <= answers) {
    const std::optional<History::Event> event = EventOf(client->ReadLine());
    if (!event.has_value()) break;
    history->Add(*event);
    if (event->kind == History::Event::Kind::kAnswered) ++read;
  }
  return read;
}

// One session under at most `kills` kills; returns how many.
absl::StatusOr<int> RunSession(const Options& options, const SoakServer& server, int kills,
                               std::mt19937_64* random, History* history) {
  constexpr uint64_t kAll = 1'000'000;
  ASSIGN_OR_RETURN(const auto client, client::FitClient::Connect({server.address()}));
  ASSIGN_OR_RETURN(const v1::Session session, client->CreateSession(SoakSession()));
  uint64_t answered = 0;
  for (int killed = 0;; ++killed) {
    RunningProgram child("/proc/self/exe", {"--address", server.address(), "--session",
                                            session.session_id(), "--first", absl::StrCat(answered),
                                            "--frames", absl::StrCat(options.frames)});
    if (killed < kills) {
      answered += ReadAnswers(&child, (*random)() % 6, history);
      absl::SleepFor(absl::Microseconds((*random)() % 4000));
      child.Signal(SIGKILL);
    }
    const uint64_t before = answered;
    answered += ReadAnswers(&child, kAll, history);  // what it wrote down before it died
    if (answered == options.frames) {
      RETURN_IF_ERROR(CheckStored(session.session_id(), options.frames, server.address()));
      return std::min(killed + 1, kills);
    }
    if (killed >= kills && before == answered) {
      return absl::UnavailableError(absl::StrCat("the last client ends at frame ", answered));
    }
  }
}

absl::Status Run(const Options& options) {
  if (!options.address.empty()) return RunClient(options);
  std::mt19937_64 random(options.seed);
  SoakServer server(options.server, options.server_arguments);
  RETURN_IF_ERROR(server.Start());
  ASSIGN_OR_RETURN(const auto undisturbed, UndisturbedBits(options.frames));
  int killed = 0, sessions = 0;
  for (; killed < options.kills; ++sessions) {
    History history;
    ASSIGN_OR_RETURN(const int more,
                     RunSession(options, server, options.kills - killed, &random, &history));
    killed += more;
    RETURN_IF_ERROR(Judge(history, undisturbed));
  }
  std::cout << killed << " kills, " << sessions << " sessions of " << options.frames
            << " frames: each answered once, in order, equal to the bit\n";
  return absl::OkStatus();
}

}  // namespace
}  // namespace cagefit::testing

int main(int argc, char** argv) {
  cagefit::testing::Options options;
  options.server = cagefit::testing::ProgramBeside("cagefitd");
  CLI::App app("Kills the client over and over while it streams.");
  app.add_option("--kills", options.kills)->capture_default_str();
  app.add_option("--seed", options.seed)->capture_default_str();
  app.add_option("--frames", options.frames, "Of a session")->capture_default_str();
  app.add_option("--server", options.server)->capture_default_str();
  app.add_option("server_arguments", options.server_arguments, "Behind --");
  app.add_option("--address", options.address, "Be a client of this server")->group("");
  app.add_option("--session", options.session_id)->group("");
  app.add_option("--first", options.first)->group("");
  CLI11_PARSE(app, argc, argv);
  return cagefit::testing::Report(cagefit::testing::Run(options), argc, argv);
}
