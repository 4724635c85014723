#include "server/session/track.h"

#include <gtest/gtest.h>

#include "tests/support/frames.h"

namespace cagefit::server {
namespace {

class TrackTest : public ::testing::Test {
 protected:
  // Everything at (x, 0, 0).
  static Points3d At(double x) { return Eigen::Vector3d(x, 0, 0).replicate(1, 4); }

  void Add(double x, Verdict verdict, double rms = 0) {
    StoredFrame answer;
    answer.outcome = Outcome::kFitted;
    answer.verdict = verdict;
    answer.distances.rms = rms;
    answer.fit.samples = 10;
    answer.fit.grown_samples = static_cast<int>(10 * rms);
    track_.Advance(answer, {At(x), {}});
  }
  // x of every start, as far as they are At something.
  std::vector<double> Starts() const {
    std::vector<double> x;
    for (const Points3d& start : track_.Starts(template_)) x.push_back(start(0, 0));
    return x;
  }

  const ControlMesh template_ = cagefit::testing::FrameCage();
  const double template_x_ = template_.vertices()(0, 0);
  Track track_;
};

TEST_F(TrackTest, BeginsWithTheTemplate) {
  EXPECT_EQ(Starts(), std::vector<double>{template_x_});
  EXPECT_EQ(track_.start_kind(), StartKind::kTemplate);
}

TEST_F(TrackTest, GoesOnFromTheLastFrameAndAlongItsMotion) {
  Add(1, Verdict::kOk);
  EXPECT_EQ(Starts(), std::vector<double>{1});
  EXPECT_EQ(track_.start_kind(), StartKind::kEarlierFit);
  Add(2, Verdict::kOk);
  const std::vector<double> starts = Starts();
  ASSERT_EQ(starts.size(), 2u);
  EXPECT_EQ(starts[0], 2);
  EXPECT_GT(starts[1], 2.5);
}

TEST_F(TrackTest, AfterALostFrameGoesBackAndForgetsTheMotion) {
  Add(1, Verdict::kOk);
  Add(2, Verdict::kSuspect);
  Add(9, Verdict::kLost);
  EXPECT_EQ(Starts(), (std::vector<double>{2, 1}));  // the last not LOST, the last OK
  Add(3, Verdict::kOk);
  EXPECT_EQ(Starts(), std::vector<double>{3});  // no motion from 9 to 3
  Add(4, Verdict::kOk);
  EXPECT_EQ(Starts().size(), 2u);
}

TEST_F(TrackTest, ALostFirstFrameLeavesTheTemplate) {
  Add(9, Verdict::kLost);
  EXPECT_EQ(Starts(), std::vector<double>{template_x_});
  EXPECT_EQ(track_.start_kind(), StartKind::kTemplate);
}

TEST_F(TrackTest, ExpectsTheMedianOfTheFramesThatWereOk) {
  FitSummary fit;
  fit.samples = 20;
  fit.grown_samples = 4;
  fit.far_samples = 1;
  EXPECT_EQ(track_.ExpectationOf(fit).bare_share, 0.25);
  const VerdictInput nothing;
  EXPECT_EQ(track_.ExpectationOf(fit).median_rms, nothing.median_rms);
  for (const double rms : {0.3, 0.1, 0.2}) Add(1, Verdict::kOk, rms);
  Add(1, Verdict::kSuspect, 0.9);
  EXPECT_EQ(track_.ExpectationOf(fit).median_rms, 0.2);
  EXPECT_EQ(track_.ExpectationOf(fit).median_bare_share, 0.2);
}

}  // namespace
}  // namespace cagefit::server
