#include "server/session/session.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameBytes;
using cagefit::testing::MovingCloud;
using testing::BadFrame;
using testing::CageConfig;
using testing::DecodedFrame;
using testing::FarFrame;
using testing::MovingFrame;
using testing::OpenSession;
using testing::ReasonOf;

TEST(SessionTest, FitsAFrame) {
  OpenSession open(CageConfig());
  const auto answer = open.Answer(MovingFrame(0));
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_FALSE(answer->repeated);
  const StoredFrame& frame = *answer->frame;
  EXPECT_EQ(frame.outcome, Outcome::kFitted);
  EXPECT_EQ(frame.verdict, Verdict::kOk);
  EXPECT_EQ(frame.points, 500);
  EXPECT_GT(frame.fit.iterations, 0);
  EXPECT_LT(frame.fit.final.total(), frame.fit.initial.total());
  EXPECT_LT(frame.rms_percent, 1);
  EXPECT_TRUE(frame.delta.key);
  EXPECT_FALSE(frame.made_template);
  EXPECT_EQ(frame.digest, Sha256(MovingFrame(0).bytes));
  EXPECT_EQ(open.ledger->Facts().fitted_frames, 1u);
}

TEST(SessionTest, KeepsNumberAndTimestampOfTheFrame) {
  OpenSession open(CageConfig());
  Frame frame = MovingFrame(0);
  frame.timestamp = absl::FromUnixNanos(1'234'567'890'123);
  const auto answer = open.Answer(std::move(frame));
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->frame->sequence_number, 0u);
  EXPECT_EQ(answer->frame->timestamp, absl::FromUnixNanos(1'234'567'890'123));
}

TEST(SessionTest, DeltasLeadToTheStateOfEveryFrame) {
  OpenSession open(CageConfig());
  GridPoints q;
  for (uint64_t number = 0; number < 5; ++number) {
    const auto answer = open.Answer(MovingFrame(number));
    ASSERT_TRUE(answer.ok()) << answer.status();
    const EncodedDelta& delta = answer->frame->delta;
    EXPECT_EQ(delta.key, number == 0);
    ASSERT_TRUE(ApplyDelta(Decode(delta, 42).value(), &q).ok());
    EXPECT_EQ(Dequantize(q, delta.grid), open.Vertices(number));
  }
}

TEST(SessionTest, TheSameFramesGiveTheSameBitsTwice) {
  OpenSession a(CageConfig()), b(CageConfig());
  for (uint64_t number = 0; number < 5; ++number) {
    ASSERT_TRUE(a.Answer(MovingFrame(number)).ok());
    ASSERT_TRUE(b.Answer(MovingFrame(number)).ok());
    EXPECT_EQ(a.Vertices(number), b.Vertices(number));
  }
}

TEST(SessionTest, ARejectedFrameIsStoredAndLeavesTheStateAsItWas) {
  OpenSession open(CageConfig()), other(CageConfig());
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  const auto rejected = open.Answer(BadFrame(1));
  ASSERT_TRUE(rejected.ok()) << rejected.status();
  EXPECT_EQ(rejected->frame->outcome, Outcome::kRejected);
  EXPECT_TRUE(absl::IsInvalidArgument(rejected->frame->error)) << rejected->frame->error;
  EXPECT_EQ(rejected->frame->delta.values.size(), 0);
  EXPECT_EQ(open.ledger->Facts().rejected_frames, 1u);
  EXPECT_EQ(open.ledger->LatestMesh()->vertices(), open.Vertices(0));

  Frame later = MovingFrame(1);
  later.sequence_number = 2;
  const auto answer = open.Answer(std::move(later));
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_FALSE(answer->frame->delta.key);
  ASSERT_TRUE(other.Answer(MovingFrame(0)).ok());
  ASSERT_TRUE(other.Answer(MovingFrame(1)).ok());
  EXPECT_EQ(open.Vertices(2), other.Vertices(1));
}

TEST(SessionTest, ARejectedFirstFrameDoesNotFixTheModel) {
  OpenSession open(CageConfig()), other(CageConfig());
  const auto rejected = open.Answer(BadFrame(0));
  ASSERT_TRUE(rejected.ok()) << rejected.status();
  Frame first = MovingFrame(0);
  first.sequence_number = 1;
  const auto answer = open.Answer(std::move(first));
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_TRUE(answer->frame->delta.key);
  ASSERT_TRUE(other.Answer(MovingFrame(0)).ok());
  EXPECT_EQ(open.Vertices(1), other.Vertices(0));
}

TEST(SessionTest, ARepeatedFrameGetsItsStoredReplyAsAKeyFrame) {
  for (const DeltaEncoding encoding : {DeltaEncoding::kPacked, DeltaEncoding::kDraco}) {
    SessionConfig config = CageConfig();
    config.delta_encoding = encoding;
    OpenSession open(std::move(config));
    for (uint64_t number = 0; number < 3; ++number) {
      ASSERT_TRUE(open.Answer(MovingFrame(number)).ok());
    }
    const auto answer = open.Answer(MovingFrame(1));
    ASSERT_TRUE(answer.ok()) << answer.status();
    EXPECT_TRUE(answer->repeated);
    EXPECT_EQ(answer->frame->sequence_number, 1u);
    EXPECT_TRUE(answer->frame->delta.key);
    GridPoints q;
    ASSERT_TRUE(ApplyDelta(Decode(answer->frame->delta, 42).value(), &q).ok());
    EXPECT_EQ(Dequantize(q, answer->frame->delta.grid), open.Vertices(1));
    EXPECT_EQ(answer->frame->fit.iterations, open.Stored(1).fit.iterations);
    EXPECT_EQ(open.ledger->Facts().next_sequence_number, 3u);

    // Its asker does not know the state after frame 2.
    const auto next = open.Answer(MovingFrame(3));
    ASSERT_TRUE(next.ok()) << next.status();
    EXPECT_FALSE(next->repeated);
    EXPECT_TRUE(next->frame->delta.key);
  }
}

TEST(SessionTest, ARepeatedRejectedFrameIsRejectedAgain) {
  OpenSession open(CageConfig());
  ASSERT_TRUE(open.Answer(BadFrame(0)).ok());
  const auto answer = open.Answer(BadFrame(0));
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_TRUE(answer->repeated);
  EXPECT_EQ(answer->frame, open.ledger->Find(0).value());
  EXPECT_EQ(open.ledger->Facts().rejected_frames, 1u);
}

TEST(SessionTest, AnEarlierNumberWithOtherBytesAlreadyExists) {
  OpenSession open(CageConfig());
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  Frame other = MovingFrame(1);
  other.sequence_number = 0;
  const absl::Status status = open.Answer(std::move(other)).status();
  EXPECT_TRUE(absl::IsAlreadyExists(status)) << status;
  EXPECT_EQ(ReasonOf(status), "SEQUENCE_CONFLICT");
  EXPECT_EQ(open.ledger->Facts().next_sequence_number, 1u);
}

TEST(SessionTest, AGapIsOutOfRangeAndNamesTheExpectedNumber) {
  OpenSession open(CageConfig());
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  const absl::Status status = open.Answer(MovingFrame(2)).status();
  EXPECT_TRUE(absl::IsOutOfRange(status)) << status;
  EXPECT_EQ(ReasonOf(status), "SEQUENCE_GAP");
  EXPECT_EQ(DetailOf(status)->value, "2");
  EXPECT_EQ(DetailOf(status)->limit, "1");
  EXPECT_EQ(open.ledger->Facts().next_sequence_number, 1u);
}

TEST(SessionTest, ASupersededEpochIsAborted) {
  OpenSession open(CageConfig());
  const uint64_t older = open.epoch;
  open.Reopen();
  const absl::Status status = open.session.Answer(MovingFrame(0), older, nullptr).status();
  EXPECT_TRUE(absl::IsAborted(status)) << status;
  EXPECT_EQ(ReasonOf(status), "EPOCH_SUPERSEDED");
  EXPECT_EQ(open.ledger->Facts().next_sequence_number, 0u);
}

TEST(SessionTest, AnEpochThatPassesDuringTheFitStoresNothing) {
  OpenSession open(CageConfig()), other(CageConfig());
  const uint64_t older = open.epoch;
  const absl::Status status = open.session
                                  .Answer(MovingFrame(0), older,
                                          [&open, older] {
                                            if (open.epoch == older) open.Reopen();
                                            return false;
                                          })
                                  .status();
  EXPECT_EQ(ReasonOf(status), "EPOCH_SUPERSEDED") << status;
  EXPECT_EQ(open.ledger->Facts().next_sequence_number, 0u);
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  ASSERT_TRUE(other.Answer(MovingFrame(0)).ok());
  EXPECT_EQ(open.Vertices(0), other.Vertices(0));
}

TEST(SessionTest, ANewStreamBeginsWithAKeyFrame) {
  OpenSession open(CageConfig());
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  ASSERT_FALSE(open.Answer(MovingFrame(1))->frame->delta.key);
  open.Reopen();
  EXPECT_TRUE(open.Answer(MovingFrame(2))->frame->delta.key);
  EXPECT_FALSE(open.Answer(MovingFrame(3))->frame->delta.key);
}

TEST(SessionTest, ACancelledFrameIsNotAnswered) {
  OpenSession open(CageConfig()), other(CageConfig());
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  const absl::Status status = open.Answer(MovingFrame(1), [] { return true; }).status();
  EXPECT_TRUE(absl::IsCancelled(status)) << status;
  EXPECT_EQ(open.ledger->Facts().next_sequence_number, 1u);

  // Sent again, it is fitted as if nothing had been.
  ASSERT_TRUE(open.Answer(MovingFrame(1)).ok());
  ASSERT_TRUE(other.Answer(MovingFrame(0)).ok());
  ASSERT_TRUE(other.Answer(MovingFrame(1)).ok());
  EXPECT_EQ(open.Vertices(1), other.Vertices(1));
}

TEST(SessionTest, AFrameAboveALimitIsNotAnswered) {
  OpenSession open(CageConfig());
  DecodeLimits limits;
  limits.max_points = 100;
  const absl::Status status =
      open.Answer(DecodedFrame(0, FrameBytes(MovingCloud(0)), limits)).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(open.ledger->Facts().next_sequence_number, 0u);
}

TEST(SessionTest, AFullSessionTakesNoMoreFramesButRepeatsThem) {
  SessionLimits limits;
  limits.max_frames = 1;
  OpenSession open(CageConfig(), limits);
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  EXPECT_TRUE(absl::IsResourceExhausted(open.Answer(MovingFrame(1)).status()));
  EXPECT_TRUE(open.Answer(MovingFrame(0))->repeated);
}

TEST(SessionTest, AfterALostFrameTheNextStartsFromTheLastGoodSurface) {
  SessionConfig config = CageConfig();
  config.fit.solver.max_iterations = 1;  // not enough to follow the jump, or to hide where it began
  OpenSession lost(config), other(config);
  ASSERT_TRUE(lost.Answer(MovingFrame(0)).ok());
  ASSERT_TRUE(other.Answer(MovingFrame(0)).ok());
  ASSERT_EQ(other.Stored(0).verdict, Verdict::kOk);
  const auto jump = lost.Answer(FarFrame(1));
  ASSERT_TRUE(jump.ok()) << jump.status();
  ASSERT_EQ(jump->frame->verdict, Verdict::kLost);
  ASSERT_NE(lost.Vertices(1), lost.Vertices(0));

  Frame back = MovingFrame(1);
  back.sequence_number = 2;
  ASSERT_TRUE(lost.Answer(std::move(back)).ok());
  ASSERT_TRUE(other.Answer(MovingFrame(1)).ok());
  EXPECT_EQ(lost.Vertices(2), other.Vertices(1));
}

TEST(SessionTest, SendsAKeyFrameAtEveryKeyInterval) {
  SessionConfig config = CageConfig();
  config.key_interval = 3;
  OpenSession open(std::move(config));
  std::vector<bool> keys;
  uint64_t number = 0;
  for (int fitted = 0; fitted < 8; ++fitted) {
    keys.push_back(open.Answer(MovingFrame(number++))->frame->delta.key);
    if (fitted == 4) {
      ASSERT_TRUE(open.Answer(BadFrame(number++)).ok());
    }
  }
  EXPECT_EQ(keys, (std::vector<bool>{true, false, false, true, false, false, true, false}));
}

TEST(SessionTest, KeyInterval1SendsKeyFramesOnly) {
  SessionConfig config = CageConfig();
  config.key_interval = 1;
  OpenSession open(std::move(config));
  for (uint64_t number = 0; number < 3; ++number) {
    EXPECT_TRUE(open.Answer(MovingFrame(number))->frame->delta.key);
  }
}

TEST(SessionTest, WithoutAQuantumPositionsAreSent) {
  SessionConfig config = CageConfig();
  config.quantum = 0;
  OpenSession open(config), other(config);
  for (uint64_t number = 0; number < 3; ++number) {
    const auto answer = open.Answer(MovingFrame(number));
    ASSERT_TRUE(answer.ok()) << answer.status();
    EXPECT_EQ(answer->frame->delta.positions.cast<double>(), open.Vertices(number));
    EXPECT_EQ(answer->frame->delta.values.size(), 0);
    ASSERT_TRUE(other.Answer(MovingFrame(number)).ok());
    EXPECT_EQ(open.Vertices(number), other.Vertices(number));
  }
  const auto repeated = open.Answer(MovingFrame(1));
  ASSERT_TRUE(repeated.ok()) << repeated.status();
  EXPECT_TRUE(repeated->repeated);
  EXPECT_EQ(repeated->frame->delta.positions.cast<double>(), open.Vertices(1));
}

// ---- Skipped frames ----

SkippedFrame SkippedMovingFrame(uint64_t number) {
  return {number, std::nullopt, MovingFrame(number).digest};
}

TEST(SessionTest, ASkippedFrameIsAnsweredAndLeavesTheSurfaceAsItWas) {
  OpenSession session(CageConfig()), other(CageConfig());
  ASSERT_TRUE(session.Answer(MovingFrame(0)).ok());
  const auto skipped = session.session.Skip(SkippedMovingFrame(1), session.epoch);
  ASSERT_TRUE(skipped.ok()) << skipped.status();
  EXPECT_EQ(skipped->frame->outcome, Outcome::kSkipped);
  EXPECT_FALSE(skipped->repeated);
  EXPECT_EQ(session.ledger->Facts().next_sequence_number, 2u);
  EXPECT_EQ(session.ledger->Facts().skipped_frames, 1u);
  EXPECT_EQ(session.ledger->Facts().rejected_frames, 0u);
  EXPECT_TRUE(absl::IsNotFound(session.ledger->MeshOfFrame(1).status()));

  // The next fit does not know of it.
  const auto fitted = session.Answer(MovingFrame(2));
  ASSERT_TRUE(fitted.ok()) << fitted.status();
  EXPECT_FALSE(fitted->frame->delta.key);
  ASSERT_TRUE(other.Answer(MovingFrame(0)).ok());
  Frame second = MovingFrame(2);
  second.sequence_number = 1;
  ASSERT_TRUE(other.Answer(std::move(second)).ok());
  EXPECT_EQ(session.Vertices(2), other.Vertices(1));
}

TEST(SessionTest, ASkippedFrameThatComesAgainGetsItsStoredAnswer) {
  OpenSession session(CageConfig());
  ASSERT_TRUE(session.session.Skip(SkippedMovingFrame(0), session.epoch).ok());
  ASSERT_TRUE(session.Answer(MovingFrame(1)).ok());
  session.Reopen();
  const auto again = session.Answer(MovingFrame(0));
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->frame->outcome, Outcome::kSkipped);
  EXPECT_TRUE(again->repeated);
  // One that was fitted may be overtaken when it comes again.
  const auto fitted = session.session.Skip(SkippedMovingFrame(1), session.epoch);
  ASSERT_TRUE(fitted.ok()) << fitted.status();
  EXPECT_EQ(fitted->frame->outcome, Outcome::kFitted);
  EXPECT_TRUE(fitted->repeated);

  SkippedFrame changed = SkippedMovingFrame(0);
  changed.digest[0] ^= 1;
  EXPECT_TRUE(absl::IsAlreadyExists(session.session.Skip(changed, session.epoch).status()));
}

TEST(SessionTest, FramesAreSkippedInOrderAndByTheStreamThatIsOpen) {
  OpenSession session(CageConfig());
  const absl::Status gap = session.session.Skip(SkippedMovingFrame(1), session.epoch).status();
  EXPECT_TRUE(absl::IsOutOfRange(gap)) << gap;
  const uint64_t old_epoch = session.epoch;
  session.Reopen();
  const absl::Status old = session.session.Skip(SkippedMovingFrame(0), old_epoch).status();
  EXPECT_TRUE(absl::IsAborted(old)) << old;
  EXPECT_EQ(session.ledger->Facts().next_sequence_number, 0u);
}

}  // namespace
}  // namespace cagefit::server
