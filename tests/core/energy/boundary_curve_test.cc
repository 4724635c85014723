#include "core/energy/boundary_curve.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "core/cloud/spacing.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Random points of the unit disk at z = 0, normals +z; with `waves` off the plane by as much.
PointCloud Disk(int count, double waves = 0) {
  Random random(1);
  PointCloud cloud;
  cloud.points.resize(3, count);
  cloud.normals.resize(3, count);
  for (int k = 0; k < count; ++k) {
    const double r = std::sqrt(random.Uniform()), turn = random.Uniform(0, 2 * kPi);
    const double x = r * std::cos(turn), y = r * std::sin(turn);
    cloud.points.col(k) << static_cast<float>(x), static_cast<float>(y),
        static_cast<float>(waves * std::sin(5 * x));
    cloud.normals.col(k) =
        Eigen::Vector3d(-5 * waves * std::cos(5 * x), 0, 1).normalized().cast<float>();
  }
  return cloud;
}

double SpacingOf(const PointCloud& cloud) {
  return MedianSpacing(cloud.points, KdTree(cloud.points));
}

BoundaryCurve BoundaryOf(const PointCloud& cloud, double spacing) {
  CellGrid grid;
  grid.Build(cloud, 4 * spacing);
  return BoundaryOfCloud(grid, spacing);
}

TEST(BoundaryCurveTest, OfAMeshLiesOnItsBoundaryEdgesAlone) {
  const TriangleMesh grid = testing::OpenGrid(4);  // the unit square
  const BoundaryCurve curve = BoundaryOfMesh(grid, 0.1);
  ASSERT_EQ(curve.size(), 16 * 3);
  for (int64_t k = 0; k < curve.size(); ++k) {
    const Eigen::Vector3f x = curve.points.col(k), t = curve.tangents.col(k);
    const float to_side = std::min({x[0], 1 - x[0], x[1], 1 - x[1]});
    EXPECT_NEAR(to_side, 0, 1e-6f);
    const bool is_vertical = std::min(x[0], 1 - x[0]) < 1e-6f;
    EXPECT_NEAR(std::abs(t[is_vertical ? 1 : 0]), 1, 1e-6f);
    EXPECT_NEAR(curve.normals(2, k), 1, 1e-6f);
  }
  EXPECT_EQ(BoundaryOfMesh(testing::Icosphere(2), 0.1).size(), 0);
}

// As files have them along the seams of a texture.
TEST(BoundaryCurveTest, RepeatedVerticesAreNoBoundary) {
  const TriangleMesh sphere = testing::Icosphere(2);
  TriangleMesh torn;
  torn.vertices.resize(3, 3 * sphere.triangles.cols());
  torn.triangles.resize(3, sphere.triangles.cols());
  for (int32_t f = 0; f < sphere.triangles.cols(); ++f) {
    for (int c = 0; c < 3; ++c) {
      torn.vertices.col(3 * f + c) = sphere.vertices.col(sphere.triangles(c, f));
      torn.triangles(c, f) = 3 * f + c;
    }
  }
  EXPECT_EQ(BoundaryOfMesh(torn, 0.1).size(), 0);
}

TEST(BoundaryCurveTest, OfACloudGoesRoundItAndNowhereElse) {
  for (const double waves : {0.0, 0.1}) {
    const PointCloud cloud = Disk(8000, waves);
    const double spacing = SpacingOf(cloud);
    const BoundaryCurve curve = BoundaryOf(cloud, spacing);
    std::vector<int> per_sector(24);
    for (int64_t k = 0; k < curve.size(); ++k) {
      const Eigen::Vector3f x = curve.points.col(k), t = curve.tangents.col(k);
      const double r = std::hypot(x[0], x[1]);
      EXPECT_NEAR(r, 1, 2 * spacing);
      EXPECT_LT(std::abs(x[0] * t[0] + x[1] * t[1]), 0.4);
      ++per_sector[static_cast<int>((std::atan2(x[1], x[0]) + kPi) / (2 * kPi) * 23.999)];
    }
    for (const int count : per_sector) EXPECT_GT(count, 0);
  }
}

TEST(BoundaryCurveTest, AClosedCloudHasNone) {
  Random random(3);
  PointCloud cloud;
  cloud.points.resize(3, 8000);
  for (int k = 0; k < 8000; ++k) {
    cloud.points.col(k) = random.NormalVector().normalized().cast<float>();
  }
  cloud.normals = cloud.points;
  EXPECT_EQ(BoundaryOf(cloud, SpacingOf(cloud)).size(), 0);
}

// The gap between two sheets, an inside and an outside, is not where either ends.
TEST(BoundaryCurveTest, SheetsThatFaceApartDoNotFillEachOthersGaps) {
  PointCloud cloud = Disk(4000);
  const PointCloud lower = Disk(4000);
  const double spacing = SpacingOf(cloud);
  PointCloud both;
  both.points.resize(3, 8000);
  both.normals.resize(3, 8000);
  both.points << cloud.points,
      lower.points.colwise() + Eigen::Vector3f(1, 0, static_cast<float>(-0.2 * spacing));
  both.normals << cloud.normals, -lower.normals;
  const int64_t alone = BoundaryOf(cloud, spacing).size();
  EXPECT_NEAR(static_cast<double>(BoundaryOf(both, spacing).size()), 2.0 * alone, 0.05 * alone);
}

}  // namespace
}  // namespace cagefit
