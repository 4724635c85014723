// A server that is told to end under live streams, and a second one that goes on with its store.
#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/fit_client.h"
#include "tests/soak/resume.h"
#include "tests/soak/sequence.h"
#include "tests/soak/soak_server.h"
#include "tests/soak/verdict.h"

namespace cagefit::testing {
namespace {

constexpr int kStreams = 20;
constexpr uint64_t kFrames = 30;
constexpr double kDrainSeconds = 5;

struct LiveStream {
  Resumption run;
  History history;
  std::atomic<uint64_t> answered{0};
  absl::Status end;
  std::thread thread;

  void Begin(const std::string& address) {
    run.address = address;
    run.session_id =
        client::FitClient::Connect({address}).value()->CreateSession(SoakSession())->session_id();
    run.frames = kFrames;
    run.seen = [this](const History::Event& event) {
      history.Add(event);
      if (event.kind == History::Event::Kind::kAnswered) ++answered;
    };
    thread = std::thread([this] { end = StreamToEnd(run); });
  }
};

TEST(TakeOverTest, StreamsGoOnAtASecondServerOfTheSameStore) {
  const auto undisturbed = UndisturbedBits(kFrames);
  ASSERT_TRUE(undisturbed.ok()) << undisturbed.status();
  SoakServer server(ProgramBeside("cagefitd"),
                    {"--store", absl::StrCat("sqlite:", EmptyFolder("store"), "/sessions.db"),
                     "--drain-seconds", absl::StrCat(kDrainSeconds)});
  ASSERT_EQ(server.Start(), absl::OkStatus());
  std::deque<LiveStream> streams(kStreams);
  for (LiveStream& stream : streams) stream.Begin(server.address());
  for (LiveStream& stream : streams) {
    while (stream.answered < 2) absl::SleepFor(absl::Milliseconds(1));
  }

  const absl::Time told = absl::Now();
  EXPECT_EQ(server.Terminate(), 0);
  EXPECT_LT(absl::Now() - told, absl::Seconds(kDrainSeconds + 1));
  int unfinished = 0;
  for (const LiveStream& stream : streams) unfinished += stream.answered < kFrames;
  EXPECT_EQ(unfinished, kStreams) << "all were live";
  ASSERT_EQ(server.Start(), absl::OkStatus());

  for (LiveStream& stream : streams) {
    stream.thread.join();
    EXPECT_EQ(stream.end, absl::OkStatus());
    EXPECT_EQ(Judge(stream.history, *undisturbed), absl::OkStatus());
    EXPECT_EQ(CheckStored(stream.run.session_id, kFrames, server.address()), absl::OkStatus());
  }
}

}  // namespace
}  // namespace cagefit::testing
