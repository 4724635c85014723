// Many sessions with open streams on as many connections, on which nothing happens; in the end each
// still fits a frame. Prints what one of them costs the server.
#include <CLI/CLI.hpp>
#include <atomic>
#include <iostream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "tests/load/load_client.h"
#include "tests/load/load_server.h"
#include "tests/support/frames.h"
#include "tests/support/sanitizer.h"

namespace cagefit::testing {
namespace {

// What a session of a small cage holds is next to nothing: all is counted.
constexpr double kMostBytesEach = kCostFactor * 65536;
// After the first few the server has started what it has once.
constexpr int kFirst = 32;
constexpr int kLevels = 1;

struct IdleClient {
  std::unique_ptr<v1::Fitting::Stub> stub;
  std::unique_ptr<LoadStream> stream;
};

// While nobody waits for an answer, gRPC answers one ping of a server in 5 s, of whichever
// connection: enough for a client that has one, but not for all clients in one process. A thread
// that waits answers them all.
class PingAnswers {
 public:
  ~PingAnswers() {
    ending_ = true;
    thread_.join();
    queue_.Shutdown();
  }

 private:
  void Wait() {
    void* tag = nullptr;
    bool ok = false;
    while (!ending_) {
      queue_.AsyncNext(&tag, &ok, std::chrono::system_clock::now() + std::chrono::seconds(1));
    }
  }

  std::atomic<bool> ending_{false};
  grpc::CompletionQueue queue_;
  std::thread thread_{[this] { Wait(); }};
};

int Fail(const std::string& what, const CallEnd& end) {
  std::cerr << what << ": " << end << "\n";
  return 1;
}

int Run(int sessions, double minutes) {
  RaiseFileLimit();
  LoadServer server({"--store", "memory", "--max-sessions", absl::StrCat(sessions + 1),
                     "--max-streams", absl::StrCat(sessions + 1), "--log-level", "warning"});
  const PingAnswers ping_answers;
  int64_t before = 0;
  std::vector<IdleClient> clients;
  CallEnd end;
  v1::StreamOpened opened;
  const absl::Time start = absl::Now();
  for (int k = 0; k < sessions; ++k) {
    if (k == kFirst) before = server.resident_bytes();
    IdleClient& client = clients.emplace_back();
    client.stub = ConnectAlone(server.address());
    const std::string id = MakeSession(client.stub.get(), kLevels, v1::PRIORITY_LIVE, &end);
    if (!end.ok()) return Fail("a session was refused", end);
    client.stream = std::make_unique<LoadStream>(client.stub.get(), id);
    if (!client.stream->Open(&opened)) {
      return Fail("a stream was refused", client.stream->Finish());
    }
  }
  std::cout << sessions << " sessions opened in " << absl::Now() - start << "\n";
  absl::SleepFor(absl::Minutes(minutes));
  const int64_t each = (server.peak_bytes() - before) / (sessions - kFirst);
  std::cout << each << " bytes each; the server has " << (server.peak_bytes() >> 20) << " MiB\n";

  const std::string frame = FrameBytes(MovingCloud(0));
  v1::FrameReply reply;
  for (IdleClient& client : clients) {
    client.stream->Send(0, frame);
    const bool is_answered = client.stream->Receive(&reply);
    client.stream->CloseSending();
    end = client.stream->Finish();
    if (!is_answered || !end.ok()) return Fail("a stream was broken", end);
    client.stream.reset();
  }
  std::cout << "each of them fitted a frame\n";
  if (static_cast<double>(each) <= kMostBytesEach) return 0;
  std::cerr << "more than " << kMostBytesEach << " bytes each\n";
  return 1;
}

}  // namespace
}  // namespace cagefit::testing

int main(int argc, char** argv) {
  CLI::App app("Sessions on which nothing happens");
  int sessions = 1000;
  double minutes = 5;
  app.add_option("--sessions", sessions)->check(CLI::Range(cagefit::testing::kFirst + 1, 100'000));
  app.add_option("--minutes", minutes)->check(CLI::NonNegativeNumber);
  CLI11_PARSE(app, argc, argv);
  return cagefit::testing::Run(sessions, minutes);
}
