// Losses of a session.
#include <gtest/gtest.h>

#include "server/session/session.h"
#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameCage;
using testing::BadFrame;
using testing::CageConfig;
using testing::DenseFrame;
using testing::FarFrame;
using testing::MovingFrame;
using testing::OpenSession;
using testing::ReasonOf;
using testing::SmallCageConfig;

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

}  // namespace
}  // namespace cagefit::server
