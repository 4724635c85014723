// Streams through a proxy that breaks connections: each fault with each seed.
//
//   proxy [--fault reset] [--seed 1] [--seeds 50] [--server cagefitd] -- SERVER ARGUMENTS
#include <CLI/CLI.hpp>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "tests/soak/resume.h"
#include "tests/soak/sequence.h"
#include "tests/soak/soak_server.h"
#include "tests/soak/verdict.h"
#include "tests/support/fault_proxy.h"

namespace cagefit::testing {
namespace {

struct Options {
  std::string fault;  // empty: each
  uint64_t seed = 1;  // the first
  uint64_t seeds = 50;
  uint64_t frames = 30;  // of a session
  int64_t half_open_ms = -1;
  std::string server;
  std::vector<std::string> server_arguments;
};

// After so many broken connections of a session the others are whole.
constexpr uint64_t kBrokenConnections = 4;
// About what a session of 30 frames sends; a fault may thus come in any of its phases.
constexpr int64_t kMostBytes = 20'000;

FaultPlan PlanOf(const Options& options, Fault fault, uint64_t seed, uint64_t connection) {
  if (connection >= kBrokenConnections) return FaultPlan();
  FaultPlan plan = RandomPlan(fault, seed, connection, kMostBytes);
  if (plan.direction == Direction::kToClient) plan.after_bytes /= 4;  // answers are smaller
  if (fault == Fault::kHalfOpen && options.half_open_ms >= 0) {
    plan.time = std::chrono::milliseconds(options.half_open_ms);
  }
  return plan;
}

absl::Status RunOne(const Options& options, const SoakServer& server, Fault fault, uint64_t seed,
                    const std::vector<std::string>& undisturbed, uint64_t* faults) {
  ASSIGN_OR_RETURN(const auto client, client::FitClient::Connect({server.address()}));
  ASSIGN_OR_RETURN(const v1::Session session, client->CreateSession(SoakSession()));
  FaultProxy proxy(server.address(),
                   [&](uint64_t connection) { return PlanOf(options, fault, seed, connection); });
  History history;
  Resumption run;
  run.address = proxy.address();
  run.session_id = session.session_id();
  run.frames = options.frames;
  run.seen = [&history](const History::Event& event) { history.Add(event); };
  RETURN_IF_ERROR(StreamToEnd(run));
  *faults += proxy.faults();
  RETURN_IF_ERROR(CheckStored(session.session_id(), options.frames, server.address()));
  return Judge(history, undisturbed);
}

absl::Status Run(const Options& options) {
  SoakServer server(options.server, options.server_arguments);
  RETURN_IF_ERROR(server.Start());
  ASSIGN_OR_RETURN(const auto undisturbed, UndisturbedBits(options.frames));
  for (const Fault fault : kFaults) {
    if (!options.fault.empty() && options.fault != NameOf(fault)) continue;
    uint64_t faults = 0;
    for (uint64_t seed = options.seed; seed < options.seed + options.seeds; ++seed) {
      const absl::Status status = RunOne(options, server, fault, seed, undisturbed, &faults);
      if (status.ok()) continue;
      return absl::Status(status.code(),
                          absl::StrCat(status.message(), "\nwith --fault ", NameOf(fault),
                                       " --seed ", seed, " --seeds 1"));
    }
    if (faults == 0) return absl::InternalError(absl::StrCat(NameOf(fault), " never happened"));
    std::cout << NameOf(fault) << ": " << options.seeds << " sessions of " << options.frames
              << " frames met " << faults
              << " faults: each frame answered once, in order, equal to the bit" << std::endl;
  }
  return absl::OkStatus();
}

}  // namespace
}  // namespace cagefit::testing

int main(int argc, char** argv) {
  cagefit::testing::Options options;
  options.server = cagefit::testing::ProgramBeside("cagefitd");
  CLI::App app("Streams through a proxy that breaks connections: each fault with each seed.");
  app.add_option("--fault", options.fault, "One fault only; default: each")
      ->check([](const std::string& name) {
        return cagefit::testing::FaultNamed(name).has_value() ? "" : "no fault is called " + name;
      });
  app.add_option("--seed", options.seed, "The first")->capture_default_str();
  app.add_option("--seeds", options.seeds)->capture_default_str();
  app.add_option("--frames", options.frames, "Of a session")->capture_default_str();
  app.add_option("--half-open-ms", options.half_open_ms,
                 "Until a half-open connection is reset; 0: never; default: by the seed");
  app.add_option("--server", options.server)->capture_default_str();
  app.add_option("server_arguments", options.server_arguments, "Behind --");
  CLI11_PARSE(app, argc, argv);
  return cagefit::testing::Report(cagefit::testing::Run(options), argc, argv);
}
