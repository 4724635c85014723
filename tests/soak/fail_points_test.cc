// The server's fail points, and what a client sees of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <string>
#include <vector>

#include "absl/time/clock.h"
#include "tests/soak/resume.h"
#include "tests/soak/sequence.h"
#include "tests/soak/soak_server.h"
#include "tests/soak/verdict.h"

namespace cagefit::testing {
namespace {

constexpr uint64_t kFrames = 6;

class FailPointsTest : public ::testing::Test {
 protected:
  // With the fail points armed that `plan` names.
  void Start(const std::string& program, const std::string& plan) {
    setenv("CAGEFITD_FAIL_POINTS", plan.c_str(), /*overwrite=*/1);
    server_.emplace(ProgramBeside(program), std::vector<std::string>());
    started_ = server_->Start();
    unsetenv("CAGEFITD_FAIL_POINTS");
  }

  // Streams a session to its end and checks it; how often a stream was opened.
  int Streams() {
    const auto client = client::FitClient::Connect({server_->address()});
    EXPECT_TRUE(client.ok()) << client.status();
    const auto session = (*client)->CreateSession(SoakSession());
    EXPECT_TRUE(session.ok()) << session.status();
    History history;
    int streams = 0;
    Resumption run;
    run.address = server_->address();
    run.session_id = session->session_id();
    run.frames = kFrames;
    run.patience = absl::Seconds(2);
    run.seen = [&](const History::Event& event) {
      history.Add(event);
      if (event.kind == History::Event::Kind::kOpened) ++streams;
    };
    streamed_ = StreamToEnd(run);
    if (streamed_.ok()) {
      EXPECT_EQ(Judge(history, UndisturbedBits(kFrames).value()), absl::OkStatus());
    }
    return streams;
  }

  std::optional<SoakServer> server_;
  absl::Status started_, streamed_;
};

TEST_F(FailPointsTest, TheServerThatIsShippedHasNone) {
  Start("cagefitd", "session.before_fit=kill");
  EXPECT_FALSE(started_.ok());
}

TEST_F(FailPointsTest, APlanThatIsNotUnderstoodIsRefused) {
  Start("cagefitd_faults", "session.before_fit=explode");
  EXPECT_FALSE(started_.ok());
}

TEST_F(FailPointsTest, WithoutAPlanNothingFails) {
  Start("cagefitd_faults", "");
  ASSERT_EQ(started_, absl::OkStatus());
  EXPECT_EQ(Streams(), 1);
  EXPECT_EQ(streamed_, absl::OkStatus());
}

TEST_F(FailPointsTest, AnErrorAtAPointBreaksTheStreamOnceAndNothingElse) {
  for (const std::string point :
       {"session.before_fit", "session.before_store", "stream.before_reply"}) {
    SCOPED_TRACE(point);
    Start("cagefitd_faults", point + "=error:UNAVAILABLE@4");
    ASSERT_EQ(started_, absl::OkStatus());
    EXPECT_EQ(Streams(), 2);
    EXPECT_EQ(streamed_, absl::OkStatus());
  }
}

TEST_F(FailPointsTest, AnErrorAtOneFrameIsMetByThatFrameAgainAndAgain) {
  Start("cagefitd_faults", "session.before_fit=error:UNAVAILABLE@#3");
  EXPECT_GT(Streams(), 2);
  EXPECT_THAT(std::string(streamed_.message()), ::testing::HasSubstr("no answer to frame 3 for"));
}

TEST_F(FailPointsTest, AnErrorOfASolverRejectsTheFrame) {
  Start("cagefitd_faults", "session.before_fit=error:INTERNAL@#3");
  Streams();
  EXPECT_THAT(std::string(streamed_.message()), ::testing::HasSubstr("frame 3 was rejected"));
}

TEST_F(FailPointsTest, ADelayOnlyDelays) {
  Start("cagefitd_faults", "session.before_fit=delay:30");
  const absl::Time start = absl::Now();
  EXPECT_EQ(Streams(), 1);
  EXPECT_EQ(streamed_, absl::OkStatus());
  EXPECT_GE(absl::Now() - start, kFrames * absl::Milliseconds(30));
}

TEST_F(FailPointsTest, AKillEndsTheServer) {
  Start("cagefitd_faults", "session.before_store=kill@4");
  Streams();
  EXPECT_TRUE(absl::IsDeadlineExceeded(streamed_)) << streamed_;
  EXPECT_FALSE(client::FitClient::Connect({server_->address(), absl::Seconds(1)}).ok());
}

}  // namespace
}  // namespace cagefit::testing
