#include "server/session/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameBytes;
using cagefit::testing::FrameCage;
using cagefit::testing::MovingCloud;
using cagefit::testing::SphereCloud;
using testing::CageConfig;
using testing::DecodedFrame;
using testing::MovingFrame;
using testing::OpenSession;
using testing::ReasonOf;

Frame BadFrame(uint64_t number) { return DecodedFrame(number, "no Draco"); }

// Numbered `number`, but far from all other frames.
// Two spheres far apart: no sphere comes near both.
Frame FarFrame(uint64_t number) {
  PointCloud cloud = SphereCloud(250, {500, 0, 0});
  const PointCloud other = SphereCloud(250, {0, 500, 0});
  cloud.points.conservativeResize(3, 500);
  cloud.normals.conservativeResize(3, 500);
  cloud.points.rightCols(250) = other.points;
  cloud.normals.rightCols(250) = other.normals;
  return DecodedFrame(number, FrameBytes(cloud));
}

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

TEST(SessionTest, MakesItsTemplateFromTheFirstFrame) {
  SessionConfig config;
  config.make_template = {42, 30};
  OpenSession open(std::move(config));
  open.templates.result = FrameCage();
  const auto first = open.Answer(MovingFrame(0));
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_TRUE(first->frame->made_template);
  EXPECT_EQ(open.templates.asked.vertices, 42);
  EXPECT_EQ(open.templates.asked.crease_angle_degrees, 30);
  EXPECT_EQ(open.ledger->TemplateMesh()->vertices(), FrameCage().vertices());
  EXPECT_EQ(open.ledger->Facts().control_vertices, 42);
  const auto second = open.Answer(MovingFrame(1));
  ASSERT_TRUE(second.ok()) << second.status();
  EXPECT_FALSE(second->frame->made_template);
  EXPECT_EQ(open.templates.made, 1);
}

// Too dense for a cage of 12 vertices to come near.
SessionConfig SmallCageConfig() {
  SessionConfig config;
  config.control_mesh = FrameCage(0);
  return config;
}

Frame DenseFrame(uint64_t number) {
  return DecodedFrame(number, FrameBytes(MovingCloud(static_cast<int>(number), 5000)));
}

TEST(SessionTest, InToleranceModeTheFirstFrameRefinesTheTemplate) {
  SessionConfig made;
  made.make_template.vertices = 12;
  for (SessionConfig config : {SmallCageConfig(), made}) {
    config.tolerance = ToleranceOptions{5e-4, 0};
    OpenSession open(config);
    open.templates.result = FrameCage(0);
    const auto first = open.Answer(DenseFrame(0));
    ASSERT_TRUE(first.ok()) << first.status();
    const StoredFrame& frame = *first->frame;
    ASSERT_EQ(frame.outcome, Outcome::kFitted) << frame.error;
    ASSERT_TRUE(frame.tolerance.has_value());
    EXPECT_EQ(frame.tolerance->end, ToleranceEnd::kWithin);
    EXPECT_LE(frame.tolerance->distances.most, frame.tolerance->tolerance);
    EXPECT_NEAR(frame.tolerance->tolerance, 5e-4 * frame.tolerance->diagonal, 1e-15);
    EXPECT_GT(frame.control_vertices, 12);
    EXPECT_EQ(frame.control_vertices, frame.tolerance->control_vertices);
    EXPECT_TRUE(frame.made_template);
    EXPECT_EQ(open.ledger->TemplateMesh()->vertex_count(), frame.control_vertices);
    EXPECT_EQ(open.ledger->Facts().control_vertices, frame.control_vertices);
    EXPECT_EQ(open.Vertices(0).cols(), frame.control_vertices);
    // What was reported holds for what the client has, but for its grid.
    const Frame sent = DenseFrame(0);
    const TargetDistances distances =
        DistancesToFit(*open.ledger->MeshOfFrame(0), sent.cloud->points);
    EXPECT_NEAR(Extent(distances.distance, 0).most, frame.tolerance->distances.most,
                2e-5 * frame.tolerance->diagonal);

    const auto second = open.Answer(DenseFrame(1));
    ASSERT_TRUE(second.ok()) << second.status();
    EXPECT_FALSE(second->frame->tolerance.has_value());
    EXPECT_FALSE(second->frame->made_template);
    EXPECT_EQ(open.Vertices(1).cols(), frame.control_vertices);
  }
}

TEST(SessionTest, ToleranceModeStaysWithinItsOwnAndTheServersLimit) {
  for (const auto& [own, servers] : {std::pair(20, 100'000), std::pair(100'000, 20)}) {
    SessionConfig config = SmallCageConfig();
    config.tolerance = ToleranceOptions{1e-5, own};
    SessionLimits limits;
    limits.max_control_vertices = servers;
    OpenSession open(config, limits);
    const auto answer = open.Answer(DenseFrame(0));
    ASSERT_TRUE(answer.ok()) << answer.status();
    ASSERT_TRUE(answer->frame->tolerance.has_value());
    EXPECT_EQ(answer->frame->tolerance->end, ToleranceEnd::kVertexLimit);
    EXPECT_EQ(answer->frame->control_vertices, 20);
  }
}

TEST(SessionTest, ACancelledRefinementIsNotAnswered) {
  SessionConfig config = SmallCageConfig();
  config.tolerance = ToleranceOptions();
  OpenSession open(config);
  EXPECT_TRUE(absl::IsCancelled(open.Answer(DenseFrame(0), [] { return true; }).status()));
  EXPECT_EQ(open.ledger->Facts().control_vertices, 12);
}

TEST(SessionTest, AFrameThatGivesNoTemplateIsRejectedAndTheNextTried) {
  SessionConfig config;
  config.make_template.vertices = 42;
  OpenSession open(std::move(config));
  open.templates.result = absl::InvalidArgumentError("no surface");
  const auto first = open.Answer(MovingFrame(0));
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->frame->outcome, Outcome::kRejected);
  EXPECT_FALSE(first->frame->made_template);
  open.templates.result = FrameCage();
  EXPECT_TRUE(open.Answer(MovingFrame(1))->frame->made_template);
}

TEST(SessionTest, ATemplateAboveTheLimitIsExhaustion) {
  SessionConfig config;
  config.make_template.vertices = 40;
  SessionLimits limits;
  limits.max_control_vertices = 41;
  OpenSession open(std::move(config), limits);
  open.templates.result = FrameCage();
  const absl::Status status = open.Answer(MovingFrame(0)).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(open.ledger->Facts().next_sequence_number, 0u);
}

// ---- Losses ----

TEST(SessionTest, TheLossAgainstTheLastFrameIsThatOfTheFitter) {
  OpenSession open(CageConfig());
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  ASSERT_TRUE(open.Answer(MovingFrame(1)).ok());
  const Points3d V = 1.02 * open.Vertices(0);
  const auto loss = open.session.EvaluateLoss(V, nullptr, nullptr);
  ASSERT_TRUE(loss.ok()) << loss.status();
  Fitter fitter = *Fitter::Create(
      FrameCage(), *Normalization::FromBox(BoundingBox(MovingFrame(0).cloud->points)),
      FitOptions());
  const Frame sent = MovingFrame(1);
  Points3d gradient;
  const auto expected = fitter.Evaluate(&*sent.cloud, open.Vertices(1), V, nullptr, &gradient);
  ASSERT_TRUE(expected.ok()) << expected.status();
  EXPECT_EQ(loss->energies.total(), expected->total());
  EXPECT_EQ(loss->gradient, gradient);

  const auto by_frame = open.session.EvaluateLoss(V, &sent, nullptr);
  ASSERT_TRUE(by_frame.ok()) << by_frame.status();
  EXPECT_EQ(by_frame->gradient, gradient);
}

TEST(SessionTest, BeforeTheFirstFitTheFrameOfALossStandsForTheFirst) {
  OpenSession asked(CageConfig()), fitted(CageConfig());
  const Frame frame = MovingFrame(3);
  const auto before = asked.session.EvaluateLoss(FrameCage().vertices(), &frame, nullptr);
  ASSERT_TRUE(before.ok()) << before.status();
  EXPECT_GT(before->energies.distance, 0);
  EXPECT_GT(before->gradient.norm(), 0);
  Fitter fitter = *Fitter::Create(
      FrameCage(), *Normalization::FromBox(BoundingBox(frame.cloud->points)), FitOptions());
  EXPECT_EQ(before->energies.total(), fitter
                                          .Evaluate(&*frame.cloud, FrameCage().vertices(),
                                                    FrameCage().vertices(), nullptr, nullptr)
                                          ->total());
  // That frame fixed nothing.
  ASSERT_TRUE(asked.Answer(MovingFrame(0)).ok());
  ASSERT_TRUE(fitted.Answer(MovingFrame(0)).ok());
  EXPECT_EQ(asked.Vertices(0), fitted.Vertices(0));
}

TEST(SessionTest, LossesDoNotChangeTheAnswers) {
  OpenSession asked(CageConfig()), other(CageConfig());
  const Frame far = FarFrame(0);
  for (uint64_t number = 0; number < 4; ++number) {
    const auto answer = asked.Answer(MovingFrame(number)),
               expected = other.Answer(MovingFrame(number));
    ASSERT_TRUE(answer.ok() && expected.ok());
    EXPECT_EQ(asked.Vertices(number), other.Vertices(number));
    EXPECT_EQ(answer->frame->delta.key, expected->frame->delta.key);
    EXPECT_EQ(answer->frame->fit.final.total(), expected->frame->fit.final.total());
    const Points3d V = FrameCage().vertices();
    ASSERT_TRUE(asked.session.EvaluateLoss(V, nullptr, nullptr).ok());
    ASSERT_TRUE(asked.session.EvaluateLoss(V, &far, nullptr).ok());
  }
  EXPECT_EQ(asked.ledger->Facts().next_sequence_number, 4u);
}

TEST(SessionTest, ALossWithoutAFrameNeedsTheLastOneInMemory) {
  OpenSession open(CageConfig());
  const Points3d V = FrameCage().vertices();
  const auto reason = [&] {
    const absl::Status status = open.session.EvaluateLoss(V, nullptr, nullptr).status();
    EXPECT_EQ(absl::IsFailedPrecondition(status), !status.ok()) << status;
    return ReasonOf(status);
  };
  EXPECT_EQ(reason(), "NO_FRAME_YET");
  ASSERT_TRUE(open.Answer(MovingFrame(0)).ok());
  EXPECT_EQ(reason(), "");
  ASSERT_TRUE(open.Answer(BadFrame(1)).ok());
  EXPECT_EQ(reason(), "") << "a frame that is refused replaces none";
  EXPECT_TRUE(absl::IsCancelled(open.Answer(MovingFrame(2), [] { return true; }).status()));
  EXPECT_EQ(reason(), "FRAME_NOT_IN_MEMORY");
  ASSERT_TRUE(open.Answer(MovingFrame(2)).ok());
  EXPECT_EQ(reason(), "");
}

TEST(SessionTest, ALossNeedsTheTemplateThatIsFitted) {
  SessionConfig made;
  made.make_template.vertices = 42;
  SessionConfig refined = SmallCageConfig();
  refined.tolerance = ToleranceOptions{5e-4, 0};
  const Frame frame = MovingFrame(0);
  for (const SessionConfig& config : {made, refined}) {
    OpenSession open(config);
    const absl::Status status =
        open.session.EvaluateLoss(FrameCage(0).vertices(), &frame, nullptr).status();
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
    EXPECT_EQ(ReasonOf(status), "NO_TEMPLATE_YET");
    EXPECT_TRUE(absl::IsFailedPrecondition(open.ledger->FinalTemplate().status()));
  }
  OpenSession open(refined);
  ASSERT_TRUE(open.Answer(DenseFrame(0)).ok());
  ASSERT_TRUE(open.ledger->FinalTemplate().ok());
  EXPECT_TRUE(open.session.EvaluateLoss(open.Vertices(0), nullptr, nullptr).ok());
}

TEST(SessionTest, ALossNamesWhatItCannotTake) {
  OpenSession open(CageConfig());
  const Frame frame = MovingFrame(0), bad = BadFrame(0);
  const Points3d V = FrameCage().vertices();
  const auto error = [&](const Points3d& vertices, const Frame& of) {
    return open.session.EvaluateLoss(vertices, &of, nullptr).status();
  };
  for (int fitted = 0; fitted < 2; ++fitted) {
    EXPECT_EQ(error(V.leftCols(41), frame).message(),
              "vertices is 41 vertices; the session has 42");
    Points3d spoiled = V;
    spoiled(1, 5) = std::nan("");
    EXPECT_EQ(DetailOf(error(spoiled, frame))->field, "vertices[16]");
    spoiled(1, 5) = 1e200;
    EXPECT_EQ(DetailOf(error(spoiled, frame))->field, "vertices");
    EXPECT_EQ(ReasonOf(error(V, bad)), "BAD_FRAME");
    EXPECT_TRUE(
        absl::IsCancelled(open.session.EvaluateLoss(V, &frame, [] { return true; }).status()));
    ASSERT_TRUE(open.Answer(MovingFrame(fitted)).ok());
  }
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
