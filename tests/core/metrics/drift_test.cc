#include "core/metrics/drift.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

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

TEST(RoundTripDriftTest, IsWhatTheVerticesHaveMoved) {
  const TriangleMesh sphere = testing::Icosphere(3);
  // A turn about z moves points along the sphere, by twice the sine of half the angle times their
  // distance from the axis.
  const double angle = 0.1;
  const Points3d turned =
      Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix() * sphere.vertices;
  const double chord = 2 * std::sin(angle / 2);
  const Eigen::ArrayXd arms = sphere.vertices.topRows(2).colwise().norm().transpose().array();
  const DriftStats slid = RoundTripDrift(sphere, turned);
  EXPECT_NEAR(slid.mean, chord * arms.mean(), 1e-12);
  EXPECT_NEAR(slid.rms, chord * std::sqrt(arms.square().mean()), 1e-12);
  EXPECT_NEAR(slid.max, chord, 1e-12);
  EXPECT_NEAR(slid.tangential_mean, slid.mean, 2e-3 * slid.mean);
  const DriftStats grown = RoundTripDrift(sphere, 1.25 * sphere.vertices);
  EXPECT_NEAR(grown.mean, 0.25, 1e-12);
  EXPECT_LT(grown.tangential_mean, 1e-3);
  EXPECT_EQ(RoundTripDrift(sphere, sphere.vertices).max, 0);
}

TEST(CombineDriftTest, CountsEveryFrameAlike) {
  const DriftStats total = Combine({{1, 3, 5, 0.5}, {3, 4, 4, 1.5}});
  EXPECT_EQ(total.mean, 2);
  EXPECT_NEAR(total.rms, std::sqrt(12.5), 1e-12);
  EXPECT_EQ(total.max, 5);
  EXPECT_EQ(total.tangential_mean, 1);
  EXPECT_EQ(Combine({}).rms, 0);
}

}  // namespace
}  // namespace cagefit
