// Sessions that make or refine their template.
#include <gtest/gtest.h>

#include "server/session/session.h"
#include "tests/server/session/session_fixture.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameCage;
using testing::DenseFrame;
using testing::MovingFrame;
using testing::OpenSession;
using testing::SmallCageConfig;

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

}  // namespace
}  // namespace cagefit::server
