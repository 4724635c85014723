// Replicas behind nginx that share a PostgreSQL, and are killed in turn while clients stream.
//
//   scale [--replicas 3] [--streams 30] [--kills 100] [--seed 1] [--seconds 20]
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <deque>
#include <iostream>
#include <optional>
#include <random>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/clock.h"
#include "core/base/status.h"
#include "tests/soak/nginx_proxy.h"
#include "tests/soak/resume.h"
#include "tests/soak/sequence.h"
#include "tests/soak/soak_server.h"
#include "tests/soak/verdict.h"
#include "tests/support/postgres_server.h"

namespace cagefit::testing {
namespace {

struct Options {
  int replicas = 3, streams = 30, kills = 100;
  uint64_t seed = 1;
  uint64_t frames = 40;  // of a session; each stream makes one after the other
  double seconds = 20;   // that throughput is measured for
  double longest_gap = 5;
  std::string server;
};

// Replicas, their store and what is in front of them.
class Farm {
 public:
  Farm(const Options& options, int replicas) {
    const std::string store = "postgres:" + postgres_.NewDatabase();
    std::vector<std::string> addresses;
    for (int k = 0; k < replicas; ++k) {
      replicas_.emplace_back(options.server, std::vector<std::string>{"--store", store});
      addresses.push_back(replicas_.back().address());
    }
    proxy_.emplace(addresses);
  }

  absl::Status Start() {
    for (SoakServer& replica : replicas_) RETURN_IF_ERROR(replica.Start());
    return proxy_->Start();
  }
  const std::string& address() const { return proxy_->address(); }
  std::deque<SoakServer>& replicas() { return replicas_; }
  const std::deque<SoakServer>& replicas() const { return replicas_; }

 private:
  PostgresServer postgres_;
  std::deque<SoakServer> replicas_;
  std::optional<NginxProxy> proxy_;
};

absl::StatusOr<std::string> NewSession(const std::string& address) {
  for (const absl::Time deadline = absl::Now() + absl::Seconds(30);;) {
    const auto client = client::FitClient::Connect({address});
    auto session = client.ok() ? (*client)->CreateSession(SoakSession()) : client.status();
    if (session.ok()) return session->session_id();
    if (absl::Now() > deadline) return session.status();
    absl::SleepFor(absl::Milliseconds(20));
  }
}

// Streams session after session until it is stopped, in the middle of one.
class Streamer {
 public:
  Streamer(const Options& options, std::string address, const std::vector<std::string>& undisturbed)
      : options_(options),
        address_(std::move(address)),
        undisturbed_(undisturbed),
        thread_([this] { status_ = Run(); }) {}

  void Stop() { stopped_ = true; }
  absl::Status Join() {
    thread_.join();
    return status_;
  }
  int64_t answered() const { return answered_; }
  absl::Duration longest_gap() const {
    return longest_gap_;
  }  // between the last sign of life before a kill and the next answer
  int breaks() const { return breaks_; }

 private:
  absl::Status Run() {
    while (!stopped_) {
      ASSIGN_OR_RETURN(const std::string id, NewSession(address_));
      History history;
      absl::Time last = absl::Now(), opened = last;
      bool has_broken = false;
      Resumption run;
      run.address = address_;
      run.session_id = id;
      run.frames = options_.frames;
      run.seen = [&](const History::Event& event) {
        history.Add(event);
        if (event.kind == History::Event::Kind::kOpened) {
          // Killed again before it was answered: from there on.
          if (has_broken) last = opened;
          opened = absl::Now();
          has_broken = history.events().size() > 1;
          breaks_ += has_broken;
        }
        if (event.kind != History::Event::Kind::kAnswered) return;
        const absl::Time now = absl::Now();
        if (std::exchange(has_broken, false)) longest_gap_ = std::max(longest_gap_, now - last);
        last = now;
        ++answered_;
      };
      RETURN_IF_ERROR(StreamToEnd(run));
      RETURN_IF_ERROR(Judge(history, undisturbed_));
      RETURN_IF_ERROR(CheckStored(id, options_.frames, address_));
    }
    return absl::OkStatus();
  }

  const Options& options_;
  const std::string address_;
  const std::vector<std::string>& undisturbed_;
  std::atomic<bool> stopped_{false};
  std::atomic<int64_t> answered_{0};
  std::atomic<int> breaks_{0};
  absl::Duration longest_gap_;
  absl::Status status_;
  std::thread thread_;
};

struct Outcome {
  double per_second = 0;
  int breaks = 0;
  absl::Duration longest_gap;
};

// Streams through the farm while `work` runs.
template <typename Work>
absl::StatusOr<Outcome> StreamWhile(const Options& options, Farm* farm,
                                    const std::vector<std::string>& undisturbed, const Work& work) {
  std::deque<Streamer> streamers;
  for (int k = 0; k < options.streams; ++k) {
    streamers.emplace_back(options, farm->address(), undisturbed);
  }
  const auto answered = [&streamers] {
    int64_t sum = 0;
    for (const Streamer& streamer : streamers) sum += streamer.answered();
    return sum;
  };
  while (answered() < options.streams) absl::SleepFor(absl::Milliseconds(5));
  const int64_t before = answered();
  const absl::Time start = absl::Now();
  absl::Status status = work();
  Outcome outcome;
  outcome.per_second =
      static_cast<double>(answered() - before) / absl::ToDoubleSeconds(absl::Now() - start);
  for (Streamer& streamer : streamers) streamer.Stop();
  for (Streamer& streamer : streamers) {
    status.Update(streamer.Join());
    outcome.breaks += streamer.breaks();
    outcome.longest_gap = std::max(outcome.longest_gap, streamer.longest_gap());
  }
  RETURN_IF_ERROR(status);
  return outcome;
}

absl::Status Kill(const Options& options, Farm* farm) {
  std::mt19937_64 random(options.seed);
  for (int k = 0; k < options.kills; ++k) {
    SoakServer& replica = farm->replicas()[random() % farm->replicas().size()];
    absl::SleepFor(absl::Milliseconds(random() % 400));
    replica.Kill();
    // Dead for longer than its clients wait: another has to take over.
    absl::SleepFor(absl::Milliseconds(300 + random() % 700));
    RETURN_IF_ERROR(replica.Start());
  }
  return absl::OkStatus();
}

// Ends every replica in turn as an update does, and starts it again.
absl::Status RestartInTurn(Farm* farm) {
  for (SoakServer& replica : farm->replicas()) {
    const int exit_code = replica.Terminate();
    if (exit_code != 0) {
      return absl::InternalError(absl::StrCat("a replica ended with exit code ", exit_code));
    }
    RETURN_IF_ERROR(replica.Start());
    absl::SleepFor(absl::Seconds(1));
  }
  return absl::OkStatus();
}

// Each replica works at least an eighth as much as the one that works most. Which of them a session
// goes to is as good as drawn, so it takes many: of 60 on three replicas, one gets fewer than six
// once in 100,000 times.
absl::Status CheckSpread(const Farm& farm) {
  const auto seconds = [&farm] {
    std::vector<double> each;
    for (const SoakServer& replica : farm.replicas()) each.push_back(replica.CpuSeconds());
    return each;
  };
  const std::vector<double> before = seconds();
  for (int k = 0; k < 20 * static_cast<int>(farm.replicas().size()); ++k) {
    Resumption run;
    run.address = farm.address();
    ASSIGN_OR_RETURN(run.session_id, NewSession(run.address));
    run.frames = 3;
    run.seen = [](const History::Event&) {};
    RETURN_IF_ERROR(StreamToEnd(run));
  }
  std::vector<double> work = seconds();
  for (size_t k = 0; k < work.size(); ++k) work[k] -= before[k];
  const std::string text =
      absl::StrCat("seconds of work of the replicas: ", absl::StrJoin(work, ", "));
  std::cout << text << "\n";
  const auto [least, most] = std::minmax_element(work.begin(), work.end());
  if (*least >= *most / 8) return absl::OkStatus();
  return absl::InternalError(text + ": sessions are not spread");
}

absl::Status Run(const Options& options) {
  ASSIGN_OR_RETURN(const auto undisturbed, UndisturbedBits(options.frames));
  const auto wait = [&options] {
    absl::SleepFor(absl::Seconds(options.seconds));
    return absl::OkStatus();
  };
  double alone = 0;
  {
    Farm one(options, 1);
    RETURN_IF_ERROR(one.Start());
    ASSIGN_OR_RETURN(const Outcome outcome, StreamWhile(options, &one, undisturbed, wait));
    alone = outcome.per_second;
  }
  Farm farm(options, options.replicas);
  RETURN_IF_ERROR(farm.Start());
  RETURN_IF_ERROR(CheckSpread(farm));
  ASSIGN_OR_RETURN(const Outcome quiet, StreamWhile(options, &farm, undisturbed, wait));
  std::cout << options.streams << " streams: " << alone << " frames a second of one replica, "
            << quiet.per_second << " of " << options.replicas << " on the same "
            << std::thread::hardware_concurrency() << " cores\n";
  ASSIGN_OR_RETURN(const Outcome killed,
                   StreamWhile(options, &farm, undisturbed, [&] { return Kill(options, &farm); }));
  std::cout << options.kills << " kills, " << killed.breaks
            << " broken streams: each frame answered once, in order, equal to the bit; the next "
               "answer after "
            << killed.longest_gap << " at most\n";
  ASSIGN_OR_RETURN(const Outcome restarted,
                   StreamWhile(options, &farm, undisturbed, [&] { return RestartInTurn(&farm); }));
  std::cout << options.replicas << " replicas restarted in turn, " << restarted.breaks
            << " broken streams: likewise; the next answer after " << restarted.longest_gap
            << " at most\n";
  if (restarted.longest_gap > absl::Seconds(options.longest_gap)) {
    return absl::DeadlineExceededError("which is too long");
  }
  if (killed.longest_gap <= absl::Seconds(options.longest_gap)) return absl::OkStatus();
  return absl::DeadlineExceededError("which is too long");
}

}  // namespace
}  // namespace cagefit::testing

int main(int argc, char** argv) {
  cagefit::testing::Options options;
  options.server = cagefit::testing::ProgramBeside("cagefitd");
  CLI::App app("Replicas behind nginx that are killed in turn while clients stream.");
  app.add_option("--replicas", options.replicas)->capture_default_str();
  app.add_option("--streams", options.streams)->capture_default_str();
  app.add_option("--kills", options.kills)->capture_default_str();
  app.add_option("--seed", options.seed)->capture_default_str();
  app.add_option("--frames", options.frames, "Of a session")->capture_default_str();
  app.add_option("--seconds", options.seconds, "To measure throughput for")->capture_default_str();
  app.add_option("--longest-gap", options.longest_gap, "Seconds between answers around a kill")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return cagefit::testing::Report(cagefit::testing::Run(options), argc, argv);
}
