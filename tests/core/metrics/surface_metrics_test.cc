#include "core/metrics/surface_metrics.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

TEST(SurfaceMetricsTest, ConcentricSpheresAreTheirRadiiApart) {
  const TriangleMesh fit = testing::Icosphere(5, 1.0), target = testing::Icosphere(5, 1.1);
  const SurfaceMetrics metrics = CompareToMesh(fit, target);
  EXPECT_NEAR(metrics.target_to_fit.rms, 0.1, 1e-3);
  EXPECT_NEAR(metrics.fit_to_target.mean, 0.1, 1e-3);
  EXPECT_NEAR(metrics.hausdorff(), 0.1, 2e-3);
  EXPECT_NEAR(metrics.symmetric_rms(), 0.1, 1e-3);
  EXPECT_NEAR(metrics.diagonal, 2.2 * std::sqrt(3.0), 0.01);
  EXPECT_NEAR(metrics.Percent(0.022 * std::sqrt(3.0)), 1, 0.01);
  EXPECT_FALSE(metrics.approximate);
  EXPECT_EQ(metrics.target_to_fit.samples, target.vertices.cols() + 10 * target.triangles.cols());
}

TEST(SurfaceMetricsTest, AHoleInTheFitShowsFromTheTargetOnly) {
  const TriangleMesh target = testing::OpenGrid(10);
  TriangleMesh fit = target;
  fit.triangles = target.triangles.leftCols(target.triangles.cols() / 2).eval();  // y < 1/2
  const SurfaceMetrics metrics = CompareToMesh(fit, target);
  EXPECT_NEAR(metrics.target_to_fit.max, 0.5, 1e-9);
  EXPECT_LT(metrics.fit_to_target.max, 1e-9);
  EXPECT_NEAR(metrics.hausdorff(), 0.5, 1e-9);
}

TEST(SurfaceMetricsTest, TangentPlanesEndWhereTheCloudDoes) {
  // A cloud in z = 0 over the unit square, and a fit in z = 0.1 that reaches a unit farther.
  const TriangleMesh square = testing::OpenGrid(50);
  PointCloud cloud;
  cloud.points = square.vertices.cast<float>();
  cloud.normals = Eigen::Vector3f(0, 0, 1).replicate(1, cloud.size());
  TriangleMesh fit = testing::OpenGrid(20);
  fit.vertices.row(0) *= 2;
  fit.vertices.row(2).setConstant(0.1);
  const SurfaceMetrics metrics = CompareToCloud(fit, cloud);
  EXPECT_TRUE(metrics.approximate);
  EXPECT_NEAR(metrics.target_to_fit.max, 0.1, 1e-6);
  EXPECT_NEAR(metrics.fit_to_target.max, std::hypot(1.0, 0.1), 1e-3);
  cloud.normals.resize(3, 0);
  EXPECT_GT(CompareToCloud(fit, cloud).fit_to_target.mean, metrics.fit_to_target.mean);
}

TEST(SurfaceMetricsTest, StatisticsAreThoseOfTheDistances) {
  const TriangleMesh plane = testing::OpenGrid(1);
  Points3d points(3, 3);
  points << 0.5, 0.5, 0.5, 0.5, 0.5, 0.5, 0, 1, 2;
  const DistanceStats stats =
      DistancesToSurface(points, TriangleBvh(plane.vertices, plane.triangles));
  EXPECT_NEAR(stats.mean, 1, 1e-12);
  EXPECT_NEAR(stats.rms, std::sqrt(5.0 / 3), 1e-12);
  EXPECT_NEAR(stats.max, 2, 1e-12);
  EXPECT_EQ(stats.samples, 3);
}

}  // namespace
}  // namespace cagefit
