#include "core/cloud/spacing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cagefit {
namespace {

TEST(SpacingTest, OfASquareGridIsItsDiagonal) {
  // Four neighbours at 1 and four at the root of 2: the 6th is one of these.
  Points3f points(3, 60 * 60);
  for (int i = 0; i < points.cols(); ++i) {
    points.col(i) << static_cast<float>(i % 60), static_cast<float>(i / 60), 0;
  }
  EXPECT_NEAR(MedianSpacing(points, KdTree(points)), std::sqrt(2.0), 1e-6);
}

TEST(SpacingTest, OfFewPointsReachesTheFarthest) {
  Points3f points(3, 2);
  points << 0, 3, 0, 4, 0, 0;
  EXPECT_NEAR(MedianSpacing(points, KdTree(points)), 5, 1e-6);
}

}  // namespace
}  // namespace cagefit
