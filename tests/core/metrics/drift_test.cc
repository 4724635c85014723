#include "core/metrics/drift.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

TEST(DriftMeterTest, ASurfaceThatMovesWithItsMaterialDoesNotDrift) {
  const TriangleMesh sphere = testing::Icosphere(2);
  const Points3d truth = testing::Icosphere(3).vertices;
  const DriftMeter meter(sphere, truth);
  const Eigen::Vector3d shift(1, -2, 3);
  const DriftStats still = meter.Measure(sphere.vertices, truth);
  const DriftStats moved =
      meter.Measure(sphere.vertices.colwise() + shift, truth.colwise() + shift);
  EXPECT_LT(still.max, 1e-12);
  EXPECT_LT(moved.max, 1e-12);
}

TEST(DriftMeterTest, SlidingInTheSurfaceIsTangential) {
  const TriangleMesh grid = testing::OpenGrid(4);
  Points3d truth(3, 1);
  truth << 0.4, 0.3, 0;
  const DriftMeter meter(grid, truth);
  const Points3d slid = grid.vertices.colwise() + Eigen::Vector3d(0.03, 0.04, 0);
  const DriftStats tangential = meter.Measure(slid, truth);
  EXPECT_NEAR(tangential.mean, 0.05, 1e-12);
  EXPECT_NEAR(tangential.tangential_mean, 0.05, 1e-12);
  const Points3d lifted = grid.vertices.colwise() + Eigen::Vector3d(0, 0, 0.05);
  const DriftStats normal = meter.Measure(lifted, truth);
  EXPECT_NEAR(normal.rms, 0.05, 1e-12);
  EXPECT_NEAR(normal.tangential_mean, 0, 1e-12);
}

TEST(DriftMeterTest, OneBadPointShowsInTheMaximum) {
  const TriangleMesh grid = testing::OpenGrid(1);
  Points3d truth(3, 4);
  truth << 0.2, 0.4, 0.6, 0.8, 0.5, 0.5, 0.5, 0.5, 0, 0, 0, 0;
  const DriftMeter meter(grid, truth);
  Points3d moved = truth;
  moved(2, 3) = 0.4;
  const DriftStats drift = meter.Measure(grid.vertices, moved);
  EXPECT_NEAR(drift.max, 0.4, 1e-12);
  EXPECT_NEAR(drift.mean, 0.1, 1e-12);
  EXPECT_NEAR(drift.rms, 0.2, 1e-12);
}

}  // namespace
}  // namespace cagefit
