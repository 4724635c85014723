#include "core/fit/frame_target.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/shapes.h"
#include "tests/support/spoiled_cloud.h"

namespace cagefit {
namespace {

using testing::WithFlippedNormals;
using testing::WithNoise;
using testing::WithOutliers;

constexpr int64_t kControlVertices = 300;

// A sphere of radius 100, not at the origin: the user's unit is a millimetre.
PointCloud UserCloud() {
  PointCloud cloud = CloudFromMesh(testing::Icosphere(6, 100));
  cloud.points.colwise() += Eigen::Vector3f(10, -20, 30);
  return cloud;
}

class FrameTargetTest : public ::testing::Test {
 protected:
  FrameTargetTest()
      : clean_(UserCloud()), normalization_(*Normalization::FromBox(BoundingBox(clean_.points))) {}

  absl::Status Build(const PointCloud& cloud, const FitOptions& options = {}) {
    return frame_.Build(cloud, normalization_, options, kControlVertices);
  }
  const ObjectiveTarget& target() const { return frame_.objective_target(); }
  double ToUnit(double length) const { return length * normalization_.scale; }

  PointCloud clean_;
  Normalization normalization_;
  FrameTarget frame_;
};

TEST_F(FrameTargetTest, HoldsTheCloudInUnitCoordinates) {
  ASSERT_TRUE(Build(clean_).ok());
  const Points3d unit = normalization_.ToUnit(clean_.points.cast<double>());
  EXPECT_NEAR((frame_.cloud().points.cast<double>() - unit).cwiseAbs().maxCoeff(), 0, 1e-7);
  EXPECT_EQ(frame_.cloud().normals, clean_.normals);
  EXPECT_EQ(target().index, &frame_.index());
  EXPECT_EQ(frame_.outliers(), 0);
}

TEST_F(FrameTargetTest, ChoosesARadiusBySpacingWhereTheFrameIsClean) {
  ASSERT_TRUE(Build(clean_).ok());
  const double spacing = frame_.index().spacing();
  EXPECT_LT(kRadiusPerNoise * frame_.noise(), spacing);
  EXPECT_DOUBLE_EQ(frame_.index().radius(), DistanceOptions().radius_factor * spacing);
  EXPECT_DOUBLE_EQ(target().far_radius, 3 * frame_.index().radius());

  FitOptions wider;
  wider.distance.radius_factor = 5;
  ASSERT_TRUE(Build(clean_, wider).ok());
  EXPECT_DOUBLE_EQ(frame_.index().radius(), 5 * frame_.index().spacing());
  EXPECT_NEAR(frame_.index().spacing(), spacing, 0.01 * spacing);
}

TEST_F(FrameTargetTest, LeavesOutliersOutAndCountsThem) {
  const PointCloud spoiled = WithOutliers(clean_, 0.01);
  const int64_t strays = spoiled.size() - clean_.size();
  ASSERT_TRUE(Build(spoiled).ok());
  const Eigen::Vector3f center(10, -20, 30);
  const auto off = (spoiled.points.colwise() - center).colwise().norm().array() - 100;
  EXPECT_GE(frame_.outliers(), (off.abs() > 10).count());
  EXPECT_LE(frame_.outliers(), strays);
  EXPECT_EQ(frame_.cloud().size(), spoiled.size() - frame_.outliers());
  // The index does not know them either.
  int64_t farthest = 0;
  off.abs().maxCoeff(&farthest);
  const Eigen::Vector3d stray =
      normalization_.ToUnit(spoiled.points.col(farthest).cast<double>()).col(0);
  EXPECT_GT((frame_.index().point(frame_.index().Nearest(stray)) - stray).norm(), ToUnit(10));

  FitOptions keep;
  keep.target.remove_outliers = false;
  ASSERT_TRUE(Build(spoiled, keep).ok());
  EXPECT_EQ(frame_.outliers(), 0);
  EXPECT_EQ(frame_.cloud().size(), spoiled.size());
}

TEST_F(FrameTargetTest, TurnsFlippedNormalsBack) {
  const PointCloud spoiled = WithFlippedNormals(clean_, 0.05);
  const auto count_wrong = [&] {
    const auto agreement = frame_.cloud().normals.cwiseProduct(clean_.normals).colwise().sum();
    return (agreement.array() < 0).count();
  };
  FitOptions keep;
  keep.target.repair_normals = false;
  ASSERT_TRUE(Build(spoiled, keep).ok());
  EXPECT_EQ(frame_.cloud().normals, spoiled.normals);
  const int64_t flipped = count_wrong();
  ASSERT_GT(flipped, clean_.size() / 25);

  ASSERT_TRUE(Build(spoiled).ok());
  EXPECT_LT(count_wrong(), flipped / 100);
  // The index has them, too: the field is negative inside.
  const Eigen::Vector3d inside = 0.99 * frame_.cloud().points.col(0).cast<double>();
  EXPECT_NEAR(EvaluateImls(frame_.index().grid(), inside, frame_.index().radius()).value, -0.005,
              5e-4);
}

TEST_F(FrameTargetTest, NoiseRaisesRadiusAndStiffness) {
  ASSERT_TRUE(Build(clean_).ok());
  const double calm = frame_.ArapWeight({}, kControlVertices);
  EXPECT_NEAR(calm, kArapWeightPerVertex * kControlVertices, 0.05 * calm);
  double radius = frame_.index().radius(), alpha = calm;
  for (const double share : {0.003, 0.01}) {
    ASSERT_TRUE(Build(WithNoise(clean_, share)).ok());
    const double sigma = ToUnit(share * testing::Diagonal(clean_));
    EXPECT_NEAR(frame_.noise(), sigma, 0.25 * sigma);
    EXPECT_DOUBLE_EQ(frame_.index().radius(),
                     std::max(DistanceOptions().radius_factor * frame_.index().spacing(),
                              kRadiusPerNoise * frame_.noise()));
    EXPECT_GT(frame_.index().radius(), radius);
    const double excess = frame_.noise() / 1e-3;
    EXPECT_DOUBLE_EQ(frame_.ArapWeight({}, kControlVertices),
                     kArapWeightPerVertex * kControlVertices * (1 + excess * excess));
    EXPECT_GT(frame_.ArapWeight({}, kControlVertices), 2 * alpha);
    radius = frame_.index().radius();
    alpha = frame_.ArapWeight({}, kControlVertices);
  }
}

TEST_F(FrameTargetTest, ExplicitOptionsWin) {
  const PointCloud noisy = WithNoise(clean_, 0.01);
  FitOptions options;
  options.distance.radius = 7;
  options.distance.radius_share = 0.5;
  options.distance.far_radius = 11;
  options.distance.kernel = Kernel::kTukey;
  options.distance.kernel_scale = 0.3;
  options.arap.weight = 0.125;
  ASSERT_TRUE(Build(noisy, options).ok());
  EXPECT_DOUBLE_EQ(frame_.index().radius(), ToUnit(7));
  EXPECT_DOUBLE_EQ(target().far_radius, ToUnit(11));
  EXPECT_EQ(target().kernel.kernel, Kernel::kTukey);
  EXPECT_DOUBLE_EQ(target().kernel.scale, ToUnit(0.3));
  EXPECT_EQ(frame_.ArapWeight(options, kControlVertices), 0.125);

  options.distance.radius = 0;
  options.distance.radius_share = 0.02;
  options.distance.far_radius = 0;
  options.arap.weight = 0;
  ASSERT_TRUE(Build(noisy, options).ok());
  EXPECT_DOUBLE_EQ(frame_.index().radius(), 0.02);
  EXPECT_DOUBLE_EQ(target().far_radius, 0.06);
  EXPECT_EQ(frame_.ArapWeight(options, kControlVertices), 0);
}

TEST_F(FrameTargetTest, TheKernelsScaleIsTwiceTheNoiseButNotBelowATenthOfTheSpacing) {
  FitOptions options;
  options.distance.kernel = Kernel::kGemanMcClure;
  ASSERT_TRUE(Build(clean_, options).ok());
  ASSERT_LT(2 * frame_.noise(), 0.1 * frame_.index().spacing());
  EXPECT_DOUBLE_EQ(target().kernel.scale, 0.1 * frame_.index().spacing());
  ASSERT_TRUE(Build(WithNoise(clean_, 0.01), options).ok());
  EXPECT_DOUBLE_EQ(target().kernel.scale, 2 * frame_.noise());
}

TEST_F(FrameTargetTest, CoverageTakesPointsByControlVerticesButNotTooFew) {
  FitOptions options;
  options.coverage.weight = 2.5;
  ASSERT_TRUE(Build(clean_, options).ok());
  EXPECT_EQ(target().coverage_weight, 2.5);
  EXPECT_EQ(target().covered->size(), 16'000);  // more than 8 for each of 300
  options.coverage.points_per_vertex = 60;
  ASSERT_TRUE(Build(clean_, options).ok());
  EXPECT_EQ(target().covered->size(), 60 * kControlVertices);
}

TEST_F(FrameTargetTest, KeepsNothingOfTheFrameBefore) {
  FrameTarget fresh;
  ASSERT_TRUE(fresh.Build(clean_, normalization_, {}, kControlVertices).ok());
  ASSERT_TRUE(Build(WithNoise(WithOutliers(clean_, 0.05), 0.01)).ok());
  ASSERT_TRUE(Build(clean_).ok());
  EXPECT_EQ(frame_.noise(), fresh.noise());
  EXPECT_EQ(frame_.outliers(), 0);
  EXPECT_EQ(frame_.index().radius(), fresh.index().radius());
  EXPECT_EQ(frame_.cloud().points, fresh.cloud().points);
  EXPECT_EQ(target().kernel.scale, fresh.objective_target().kernel.scale);
}

TEST_F(FrameTargetTest, TooFewPointsAreRefused) {
  PointCloud few = clean_;
  few.points.conservativeResize(3, kMinTargetPoints - 1);
  few.normals.conservativeResize(3, kMinTargetPoints - 1);
  EXPECT_EQ(Build(few).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace cagefit
