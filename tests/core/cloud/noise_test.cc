#include "core/cloud/noise.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "tests/support/data.h"
#include "tests/support/mesh_file.h"
#include "tests/support/shapes.h"
#include "tests/support/spoiled_cloud.h"

namespace cagefit {
namespace {

using testing::Diagonal;
using testing::GridOf;
using testing::WithNoise;
using testing::WithOutliers;

PointCloud SphereCloud() { return CloudFromMesh(testing::Icosphere(6)); }
PointCloud TorusCloud() { return CloudFromMesh(testing::Torus(400, 100)); }

// In shares of the diagonal, from a grid of the same cloud.
double Estimate(const PointCloud& cloud) {
  return EstimateNoise(GridOf(cloud)).sigma / Diagonal(cloud);
}

TEST(NoiseTest, IsNoneOnCleanSurfaces) {
  EXPECT_LT(Estimate(SphereCloud()), 1e-6);
  EXPECT_LT(Estimate(TorusCloud()), 1e-5);
  EXPECT_LT(Estimate(CloudFromMesh(testing::Torus(60, 20))), 1e-5);
}

TEST(NoiseTest, IsNoneOnAPlaneWithHolesAndBorders) {
  PointCloud cloud = CloudFromMesh(testing::OpenGrid(150));
  int64_t kept = 0;
  for (int64_t i = 0; i < cloud.size(); ++i) {
    const double x = 6 * cloud.points(0, i), y = 6 * cloud.points(1, i);
    if (std::hypot(x - std::round(x), y - std::round(y)) < 0.25) continue;
    cloud.points.col(kept) = cloud.points.col(i);
    cloud.normals.col(kept++) = cloud.normals.col(i);
  }
  cloud.points.conservativeResize(3, kept);
  cloud.normals.conservativeResize(3, kept);
  EXPECT_LT(Estimate(cloud), 1e-6);
}

TEST(NoiseTest, IsThatOfTheCloudFromBelowTheSpacingToManyTimesIt) {
  for (const double share : {0.001, 0.003, 0.01, 0.02}) {
    for (const PointCloud& clean : {SphereCloud(), TorusCloud()}) {
      EXPECT_NEAR(Estimate(WithNoise(clean, share)), share, 0.2 * share);
    }
  }
}

TEST(NoiseTest, IsNotTakenInByOutliers) {
  const PointCloud clean = SphereCloud();
  EXPECT_LT(Estimate(WithOutliers(clean, 0.1)), 1e-4);
  for (const double share : {0.001, 0.01}) {
    EXPECT_NEAR(Estimate(WithOutliers(WithNoise(clean, share), 0.1)), share, 0.25 * share);
  }
}

TEST(NoiseTest, DoesNotReadNormals) {
  PointCloud cloud = WithNoise(SphereCloud(), 0.005);
  const double oriented = Estimate(cloud);
  cloud.normals.resize(3, 0);
  EXPECT_EQ(Estimate(cloud), oriented);
}

TEST(NoiseTest, GrowsWithTheUnit) {
  PointCloud cloud = WithNoise(SphereCloud(), 0.005);
  const double share = Estimate(cloud);
  cloud.points *= 1024;
  EXPECT_NEAR(Estimate(cloud), share, 1e-4 * share);
}

TEST(NoiseTest, IsTheSameForAnyNumberOfThreads) {
  const CellGrid grid = GridOf(WithNoise(SphereCloud(), 0.01));
  const NoiseEstimate all = EstimateNoise(grid);
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(EstimateNoise(grid).sigma, all.sigma);
  EXPECT_EQ(EstimateNoise(grid).radius, all.radius);
}

TEST(NoiseTest, IsZeroWhereThereIsTooLittleToSee) {
  EXPECT_EQ(EstimateNoise(GridOf(CloudFromMesh(testing::Icosphere(1)))).sigma, 0);
  PointCloud spots;  // 40 points in each of 8 places
  spots.points.resize(3, 320);
  for (int i = 0; i < 320; ++i) spots.points.col(i) << i % 2, i / 2 % 2, i / 4 % 2;
  CellGrid grid;
  grid.Build(spots, 0.5);
  EXPECT_EQ(EstimateNoise(grid).sigma, 0);
}

TEST(NoiseOnRealDataTest, IsThatOfTheBunny) {
  CAGEFIT_NEEDS_DATA();
  const PointCloud clean = CloudFromMesh(testing::ReadTestMesh("static/bunny_closed_34835.ply"));
  EXPECT_LT(Estimate(clean), 0.0001);
  for (const double share : {0.001, 0.003, 0.01, 0.02}) {
    EXPECT_NEAR(Estimate(WithNoise(clean, share)), share, 0.25 * share);
  }
}

}  // namespace
}  // namespace cagefit
