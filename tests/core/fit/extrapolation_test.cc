#include "core/fit/extrapolation.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

Points3d Turned(const Points3d& X, double angle, const Eigen::Vector3d& shift) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();
  return (Eigen::AngleAxisd(angle, axis).toRotationMatrix() * X).colwise() + shift;
}

TEST(ExtrapolationTest, ARigidMotionGoesOnExactly) {
  const Points3d before = testing::Icosphere(2).vertices;
  const Eigen::Vector3d shift(0.3, -0.2, 0.1);
  const Points3d now = Turned(before, 0.5, shift);
  for (const double momentum : {0.0, 0.8, 1.0}) {
    EXPECT_LT((ExtrapolateMotion(before, now, momentum) - Turned(now, 0.5, shift)).norm(), 1e-10);
  }
}

TEST(ExtrapolationTest, WhatBendsGoesOnByTheMomentum) {
  const Points3d before = testing::Icosphere(2).vertices;
  const Points3d now = 1.1 * before;  // about its centroid, so that the rigid part is nothing
  EXPECT_LT((ExtrapolateMotion(before, now, 0.8) - 1.18 * before).norm(), 1e-10);
  EXPECT_LT((ExtrapolateMotion(before, now, 0) - now).norm(), 1e-10);
}

}  // namespace
}  // namespace cagefit
