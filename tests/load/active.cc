// Many active sessions, and a few large ones among them, on one server: does each get its share?
// Every client has always frames waiting. Fair is the same time for every session; small sessions
// are alike, so their frames are counted.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <iostream>
#include <memory>
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
  int sessions = 40, large = 1, levels = 3, large_levels = 5, max_memory = 2048;
  int64_t points = 10'000, large_points = 100'000;
  double minutes = 5;
};

struct Client {
  int levels = 0;
  const FrameLoop* frames = nullptr;
  int64_t fitted = 0;
  double busy_ms = 0;  // that the server worked for it
  CallEnd end;
};

double BusyMs(const v1::StageMilliseconds& ms) {
  return ms.template_() + ms.index() + ms.solve() + ms.measure() + ms.encode();
}

void RunClient(const std::string& address, absl::Time until, Client* client) {
  const auto stub = ConnectAlone(address);
  const std::string id = MakeSession(stub.get(), client->levels, v1::PRIORITY_LIVE, &client->end);
  if (id.empty()) return;
  LoadStream stream(stub.get(), id);
  v1::StreamOpened opened;
  if (stream.Open(&opened)) {
    std::thread sender([&] {
      for (uint64_t number = 0; absl::Now() < until; ++number) {
        if (!stream.Send(number, client->frames->At(number))) return;
      }
      stream.CloseSending();
    });
    v1::FrameReply reply;
    while (stream.Receive(&reply)) {
      if (absl::Now() > until) continue;  // the rest of the queue
      client->fitted += reply.outcome() == v1::OUTCOME_FITTED;
      client->busy_ms += BusyMs(reply.milliseconds());
    }
    sender.join();
  }
  client->end = stream.Finish();
}

int Run(const Settings& settings) {
  LoadServer server({"--store", "memory", "--max-memory", absl::StrCat(settings.max_memory),
                     "--log-level", "warning"});
  const FrameLoop small(20, settings.points), large(20, settings.large_points);
  std::vector<Client> clients(settings.sessions + settings.large);
  for (size_t k = 0; k < clients.size(); ++k) {
    const bool is_large = k >= static_cast<size_t>(settings.sessions);
    clients[k].levels = is_large ? settings.large_levels : settings.levels;
    clients[k].frames = is_large ? &large : &small;
  }
  const absl::Time until = absl::Now() + absl::Minutes(settings.minutes);
  std::vector<std::thread> threads;
  for (Client& client : clients) {
    threads.emplace_back([&] { RunClient(server.address(), until, &client); });
  }
  for (std::thread& thread : threads) thread.join();

  bool is_good = true;
  double busy_ms = 0, frames = 0;
  for (const Client& client : clients) {
    busy_ms += client.busy_ms;
    if (client.end.ok()) continue;
    std::cerr << "a session failed: " << client.end << "\n";
    is_good = false;
  }
  int64_t slowest = clients[0].fitted;
  for (int k = 0; k < settings.sessions; ++k) {
    frames += static_cast<double>(clients[k].fitted);
    slowest = std::min(slowest, clients[k].fitted);
  }
  const double fair_ms = busy_ms / static_cast<double>(clients.size());
  const double fair_frames = frames / settings.sessions;
  std::cout << frames << " frames of " << settings.sessions << " small sessions; the slowest has "
            << slowest << ", " << slowest / fair_frames << " of the mean\n";
  for (const Client& client : clients) {
    if (client.frames == &large) {
      std::cout << "a large session: " << client.fitted << " frames, " << client.busy_ms / fair_ms
                << " of its share of time\n";
    } else if (client.busy_ms < 0.5 * fair_ms) {
      std::cerr << "a small session got " << client.busy_ms / fair_ms << " of its share of time\n";
      is_good = false;
    }
  }
  std::cout << "the server had up to " << (server.peak_bytes() >> 20) << " MiB\n";
  if (slowest < 0.5 * fair_frames || slowest == 0) is_good = false;
  if (!server.HasStayedBelow(int64_t{settings.max_memory} << 20)) {
    std::cerr << "which is more than --max-memory " << settings.max_memory << "\n";
    is_good = false;
  }
  return is_good ? 0 : 1;
}

}  // namespace
}  // namespace cagefit::testing

int main(int argc, char** argv) {
  CLI::App app("Active sessions that share a server");
  cagefit::testing::Settings settings;
  app.add_option("--sessions", settings.sessions)->check(CLI::PositiveNumber);
  app.add_option("--large", settings.large, "Large sessions beside them");
  app.add_option("--levels", settings.levels, "10 * 4^levels + 2 control vertices");
  app.add_option("--large-levels", settings.large_levels);
  app.add_option("--points", settings.points);
  app.add_option("--large-points", settings.large_points);
  app.add_option("--max-memory", settings.max_memory, "MiB");
  app.add_option("--minutes", settings.minutes)->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  return cagefit::testing::Run(settings);
}
