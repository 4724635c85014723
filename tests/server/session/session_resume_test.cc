// Sessions that go on: behind their ledger, after deaths, without the model they had.
#include <gtest/gtest.h>

#include <set>

#include "server/session/session.h"
#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using testing::CageConfig;
using testing::DecodedFrame;
using testing::FarFrame;
using testing::MovingFrame;
using testing::OpenSession;
using testing::ReasonOf;

// A frame of each kind: fitted, rejected, LOST, half of the points, and more after them.
Frame FrameOfEveryKind(uint64_t number) {
  if (number == 2) return DecodedFrame(number, "no Draco");
  if (number == 4) return FarFrame(number);
  Frame frame = MovingFrame(number);
  if (number == 6) {
    PointCloud cloud = cagefit::testing::MovingCloud(6);
    const int64_t half = cloud.size() / 2;
    cloud.points = cloud.points.leftCols(half).eval();
    cloud.normals = cloud.normals.leftCols(half).eval();
    frame = DecodedFrame(number, cagefit::testing::FrameBytes(cloud));
  }
  return frame;
}

TEST(SessionTest, GoesOnBehindAnyFrameOfALedgerWithTheSameBits) {
  constexpr uint64_t kFrames = 9;
  for (const double quantum : {1e-5, 0.0}) {
    SessionConfig config = CageConfig();
    config.quantum = quantum;
    config.key_interval = 3;
    OpenSession undisturbed(config);
    std::set<Verdict> verdicts;
    for (uint64_t number = 0; number < kFrames; ++number) {
      ASSERT_TRUE(undisturbed.Answer(FrameOfEveryKind(number)).ok());
      verdicts.insert(undisturbed.Stored(number).verdict);
    }
    ASSERT_GE(verdicts.size(), 2u);
    for (uint64_t cut = 0; cut < kFrames; ++cut) {
      OpenSession open(config);
      for (uint64_t number = 0; number < cut; ++number) {
        ASSERT_TRUE(open.Answer(FrameOfEveryKind(number)).ok());
      }
      Session after(open.ledger, &open.templates, testing::NoTime);
      open.Reopen();
      for (uint64_t number = cut; number < kFrames; ++number) {
        const auto answer = after.Answer(FrameOfEveryKind(number), open.epoch, nullptr);
        ASSERT_TRUE(answer.ok()) << answer.status();
        const StoredFrame& expected = undisturbed.Stored(number);
        EXPECT_EQ(answer->frame->verdict, expected.verdict);
        EXPECT_EQ(answer->frame->outcome, expected.outcome);
        if (expected.outcome == Outcome::kRejected) continue;
        EXPECT_EQ(open.Vertices(number), undisturbed.Vertices(number))
            << "frame " << number << " after a cut before " << cut;
      }
    }
  }
}

TEST(SessionTest, ALedgerThatDoesNotReplayIsDataLoss) {
  OpenSession open(CageConfig());
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  auto broken = std::make_shared<StoredFrame>(open.Stored(0));
  broken->sequence_number = 1;
  broken->delta.checksum ^= 1;
  ASSERT_TRUE(open.ledger->Append(open.epoch, broken, std::nullopt).ok());
  Session after(open.ledger, &open.templates, testing::NoTime);
  for (int attempt = 0; attempt < 2; ++attempt) {
    const absl::Status status = after.Answer(MovingFrame(2), open.epoch, nullptr).status();
    EXPECT_TRUE(absl::IsDataLoss(status)) << status;
  }
  EXPECT_EQ(open.ledger->Facts().next_sequence_number, 2u);
}

TEST(SessionTest, AFrameThatEndedTheProcessThreeTimesIsPoisonAndTheStreamGoesOn) {
  OpenSession open(CageConfig());
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  // The process dies in the fit: what it has begun stays begun.
  for (int death = 0; death < Session::kMostBegun; ++death) {
    open.Reopen();
    EXPECT_EQ(open.ledger->Begin(open.epoch).value(), death + 1);
  }
  open.Reopen();
  const auto poison = open.Answer(MovingFrame(1));
  ASSERT_TRUE(poison.ok()) << poison.status();
  EXPECT_EQ(poison->frame->outcome, Outcome::kRejected);
  EXPECT_TRUE(absl::IsInternal(poison->frame->error));
  EXPECT_EQ(ReasonOf(poison->frame->error), "POISON_FRAME");
  const auto next = open.Answer(MovingFrame(2));
  ASSERT_TRUE(next.ok()) << next.status();
  EXPECT_EQ(next->frame->outcome, Outcome::kFitted);
}

TEST(SessionTest, AFrameThatWasCancelledOftenIsNoPoison) {
  OpenSession open(CageConfig());
  for (int k = 0; k < 2 * Session::kMostBegun; ++k) {
    open.Reopen();
    const auto cancelled = open.Answer(MovingFrame(0), [] { return true; });
    EXPECT_TRUE(absl::IsCancelled(cancelled.status())) << cancelled.status();
  }
  open.Reopen();
  const auto answer = open.Answer(MovingFrame(0));
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->frame->outcome, Outcome::kFitted);
}

TEST(SessionTest, AFitThatWaitsForItsTurnIsNotSuspected) {
  OpenSession open(CageConfig());
  int waits = 0;
  const auto answer = open.session.Answer(MovingFrame(0), open.epoch, nullptr,
                                          {[&] { return waits < 3; },
                                           [&] {
                                             ++waits;
                                             // Were the process to end now: the first try.
                                             EXPECT_EQ(open.ledger->Begin(open.epoch).value(), 1);
                                             EXPECT_TRUE(open.ledger->Abandon(0).ok());
                                           }});
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->frame->outcome, Outcome::kFitted);
  EXPECT_EQ(waits, 3);
}

TEST(SessionTest, AFitUnderSuspicionRunsToItsEnd) {
  OpenSession open(CageConfig());
  EXPECT_EQ(open.ledger->Begin(open.epoch).value(), 1);  // and the process ended
  const auto answer =
      open.session.Answer(MovingFrame(0), open.epoch, nullptr,
                          {[] { return true; }, [] { ADD_FAILURE() << "it gave way"; }});
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->frame->outcome, Outcome::kFitted);
}

// ---- Models that were dropped ----

TEST(SessionTest, ASessionWhoseModelWasDroppedGoesOnWithTheSameBits) {
  OpenSession session(CageConfig()), other(CageConfig());
  for (uint64_t number = 0; number < 5; ++number) {
    session.session.DropModel();
    EXPECT_FALSE(session.session.has_model());
    const auto answer = session.Answer(MovingFrame(number));
    ASSERT_TRUE(answer.ok()) << answer.status();
    EXPECT_EQ(answer->frame->delta.key, number == 0);
    ASSERT_TRUE(other.Answer(MovingFrame(number)).ok());
    EXPECT_EQ(session.Vertices(number), other.Vertices(number));
    EXPECT_EQ(session.Stored(number).delta.checksum, other.Stored(number).delta.checksum);
  }
}

}  // namespace
}  // namespace cagefit::server
