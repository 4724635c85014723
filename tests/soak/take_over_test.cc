// Servers of one store: what one has begun, another goes on with.
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
#include "tests/support/postgres_server.h"

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

TEST(TakeOverTest, AnyReplicaGoesOnWithAnySession) {
  constexpr uint64_t kReplicaFrames = 40;
  const auto undisturbed = UndisturbedBits(kReplicaFrames);
  ASSERT_TRUE(undisturbed.ok()) << undisturbed.status();
  PostgresServer postgres;
  const std::string store = "postgres:" + postgres.NewDatabase();
  std::deque<SoakServer> replicas;
  for (int k = 0; k < 2; ++k) {
    replicas.emplace_back(ProgramBeside("cagefitd"), std::vector<std::string>{"--store", store});
    ASSERT_EQ(replicas.back().Start(), absl::OkStatus());
  }
  LiveStream stream;
  stream.run.session_id = client::FitClient::Connect({replicas[0].address()})
                              .value()
                              ->CreateSession(SoakSession())
                              ->session_id();
  stream.run.seen = [&stream](const History::Event& event) {
    stream.history.Add(event);
    if (event.kind == History::Event::Kind::kAnswered) ++stream.answered;
  };
  // In turn, all alive: whoever has had the session before has to notice that it has moved on.
  for (; stream.answered < 20;) {
    stream.run.address = replicas[stream.answered / 5 % 2].address();
    stream.run.first = stream.answered;
    stream.run.frames = stream.answered + 5;
    ASSERT_EQ(StreamToEnd(stream.run), absl::OkStatus());
  }
  // And when one is killed.
  stream.run.address = replicas[0].address();
  stream.run.first = stream.answered;
  stream.run.frames = kReplicaFrames;
  stream.run.patience = absl::ZeroDuration();
  std::thread killer([&] {
    while (stream.answered < 30) absl::SleepFor(absl::Milliseconds(1));
    replicas[0].Kill();
  });
  EXPECT_FALSE(StreamToEnd(stream.run).ok());
  killer.join();
  stream.run.address = replicas[1].address();
  stream.run.first = stream.answered;
  stream.run.patience = absl::Seconds(60);
  EXPECT_EQ(StreamToEnd(stream.run), absl::OkStatus());
  EXPECT_EQ(Judge(stream.history, *undisturbed), absl::OkStatus());
  EXPECT_EQ(CheckStored(stream.run.session_id, kReplicaFrames, replicas[1].address()),
            absl::OkStatus());
}

}  // namespace
}  // namespace cagefit::testing
