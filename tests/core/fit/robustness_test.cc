// Fits with default options to clouds with the faults of a capture, against the clean surface.
#include <gtest/gtest.h>

#include "core/fit/fitter.h"
#include "tests/core/fit/fit_fixture.h"
#include "tests/support/spoiled_cloud.h"

namespace cagefit {
namespace {

const Eigen::Vector3d kAxes(0.5, 0.4, 0.3);
constexpr int64_t kPoints = 20'000;

class RobustnessTest : public ::testing::Test {
 protected:
  RobustnessTest()
      : clean_(testing::EllipsoidCloud(kPoints, kAxes)), cage_(testing::SphereCage(3, 0.42)) {}

  // RMS distance of the limit surface below `highest` z from the ellipsoid, percent of the
  // diagonal. The distance is F / |grad F| to first order, F = |x / a| - 1.
  double RmsPercent(const PointCloud& target, double highest = 1) const {
    const auto normalization = Normalization::FromBox(BoundingBox(target.points));
    Points3d fitted, Q;
    const auto summary = Fitter::Create(cage_, *normalization, FitOptions())
                             ->Fit(target, {cage_.vertices()}, nullptr, nullptr, &fitted);
    EXPECT_TRUE(summary.ok()) << summary.status();
    ApplyStencils(BuildLimitMesh(cage_.topology(), cage_.tags(), 2).position, fitted, &Q);
    double sum = 0, count = 0;
    for (int64_t i = 0; i < Q.cols(); ++i) {
      if (Q(2, i) > highest) continue;
      const Eigen::Vector3d scaled = Q.col(i).cwiseQuotient(kAxes);
      const double F = scaled.norm() - 1;
      const double slope = scaled.cwiseQuotient(kAxes).norm() / scaled.norm();
      sum += F * F / (slope * slope);
      ++count;
    }
    return 100 * std::sqrt(sum / count) / testing::Diagonal(clean_);
  }

  const PointCloud clean_;
  const ControlMesh cage_;
};

TEST_F(RobustnessTest, ACleanCloudIsMet) { EXPECT_LT(RmsPercent(clean_), 0.005); }

TEST_F(RobustnessTest, NoiseAveragesOut) {
  EXPECT_LT(RmsPercent(testing::WithNoise(clean_, 0.01)), 0.4);
}

TEST_F(RobustnessTest, OutliersAreLeftOut) {
  EXPECT_LT(RmsPercent(testing::WithOutliers(clean_, 0.1)), 0.1);
}

TEST_F(RobustnessTest, TurnedNormalsAreTurnedBack) {
  EXPECT_LT(RmsPercent(testing::WithFlippedNormals(clean_, 0.05)), 0.01);
}

TEST_F(RobustnessTest, AMissingPartLeavesTheRestAlone) {
  // EllipsoidCloud goes from the top down: three tenths of it are gone.
  PointCloud part;
  part.points = clean_.points.rightCols(7 * kPoints / 10);
  part.normals = clean_.normals.rightCols(7 * kPoints / 10);
  const double rim = part.points.row(2).maxCoeff();
  EXPECT_LT(RmsPercent(part, rim - 0.02), 0.15);
}

}  // namespace
}  // namespace cagefit
