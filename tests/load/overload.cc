// Several times the work that a server has memory and streams for. It must refuse what is too much
// with RESOURCE_EXHAUSTED and a time to try again, stay within --max-memory, and be itself again
// two seconds after the load is gone.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <iostream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "tests/load/load_client.h"
#include "tests/load/load_server.h"

namespace cagefit::testing {
namespace {

struct Settings {
  int clients = 32, streams = 24, levels = 4, max_memory = 512;
  int64_t points = 100'000;
  double minutes = 2;
};

struct Tally {
  std::atomic<int64_t> fitted{0}, refused{0};
  std::mutex mutex;
  std::vector<std::string> wrong;

  // Whether the client may try again, and after what time.
  bool Take(const CallEnd& end, absl::Duration* wait) {
    const bool is_refusal = end.code == grpc::StatusCode::RESOURCE_EXHAUSTED;
    if (is_refusal && end.retry_after > absl::ZeroDuration()) {
      ++refused;
      *wait = end.retry_after;
      return true;
    }
    std::lock_guard<std::mutex> lock(mutex);
    wrong.push_back(absl::StrCat("code ", end.code, " ", end.reason, ": ", end.message));
    return false;
  }
};

// Sends as fast as it can until the stream ends or time is up.
CallEnd StreamUntil(v1::Fitting::Stub* stub, const std::string& id, const FrameLoop& frames,
                    absl::Time until, Tally* tally) {
  LoadStream stream(stub, id);
  v1::StreamOpened opened;
  if (!stream.Open(&opened)) return stream.Finish();
  std::thread sender([&] {
    for (uint64_t n = opened.next_sequence_number(); absl::Now() < until; ++n) {
      if (!stream.Send(n, frames.At(n))) return;
    }
    stream.CloseSending();
  });
  v1::FrameReply reply;
  while (stream.Receive(&reply)) tally->fitted += reply.outcome() == v1::OUTCOME_FITTED;
  sender.join();
  return stream.Finish();
}

void RunClient(const std::string& address, const Settings& settings, const FrameLoop& frames,
               absl::Time until, Tally* tally) {
  const auto stub = ConnectAlone(address);
  std::string id;
  while (absl::Now() < until) {
    CallEnd end;
    if (id.empty()) {
      id = MakeSession(stub.get(), settings.levels, v1::PRIORITY_LIVE, &end);
    } else {
      end = StreamUntil(stub.get(), id, frames, until, tally);
    }
    absl::Duration wait = absl::ZeroDuration();
    if (!end.ok() && !tally->Take(end, &wait)) return;
    absl::SleepFor(std::min(wait, until - absl::Now()));
  }
}

// How long a new client waits for its first frame.
absl::Duration FirstFrame(const std::string& address, const FrameLoop& frames) {
  const absl::Time start = absl::Now();
  const auto stub = ConnectAlone(address);
  CallEnd end;
  const std::string id = MakeSession(stub.get(), 2, v1::PRIORITY_LIVE, &end);
  if (!end.ok()) return absl::InfiniteDuration();
  LoadStream stream(stub.get(), id);
  v1::StreamOpened opened;
  v1::FrameReply reply;
  const bool is_answered = stream.Open(&opened) && stream.Send(0, frames.At(0)) &&
                           stream.Receive(&reply) && reply.outcome() == v1::OUTCOME_FITTED;
  return is_answered ? absl::Now() - start : absl::InfiniteDuration();
}

int Run(const Settings& settings) {
  LoadServer server({"--store", "memory", "--max-memory", absl::StrCat(settings.max_memory),
                     "--max-streams", absl::StrCat(settings.streams), "--log-level", "error"});
  const FrameLoop frames(10, settings.points), small(1, 1000);
  Tally tally;
  const absl::Time until = absl::Now() + absl::Minutes(settings.minutes);
  std::vector<std::thread> threads;
  for (int k = 0; k < settings.clients; ++k) {
    threads.emplace_back([&] { RunClient(server.address(), settings, frames, until, &tally); });
  }
  for (std::thread& thread : threads) thread.join();
  const absl::Duration recovery = FirstFrame(server.address(), small);
  std::cout << tally.fitted << " frames fitted, " << tally.refused
            << " calls refused with a retry time; the server had up to "
            << (server.peak_bytes() >> 20) << " of " << settings.max_memory
            << " MiB; afterwards a first frame took " << recovery << "\n";
  for (const std::string& wrong : tally.wrong) std::cerr << "not a refusal: " << wrong << "\n";
  const bool is_good = tally.wrong.empty() && tally.fitted > 0 && tally.refused > 0 &&
                       server.HasStayedBelow(int64_t{settings.max_memory} << 20) &&
                       recovery < absl::Seconds(2);
  return is_good ? 0 : 1;
}

}  // namespace
}  // namespace cagefit::testing

int main(int argc, char** argv) {
  CLI::App app("More load than a server can carry");
  cagefit::testing::Settings settings;
  app.add_option("--clients", settings.clients)->check(CLI::PositiveNumber);
  app.add_option("--streams", settings.streams, "--max-streams of the server");
  app.add_option("--levels", settings.levels, "10 * 4^levels + 2 control vertices");
  app.add_option("--points", settings.points);
  app.add_option("--max-memory", settings.max_memory, "MiB");
  app.add_option("--minutes", settings.minutes)->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  return cagefit::testing::Run(settings);
}
