#include "core/template/fine_surface.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

TEST(FineSurfaceTest, FindsPointsAndNormalsOfTheSurface) {
  const FineSurface surface({testing::OpenGrid(4), {}});
  EXPECT_NEAR(surface.diagonal(), std::sqrt(2.0), 1e-6);
  const auto point = surface.Nearest({0.3, 0.4, 0.2}, 1);
  ASSERT_TRUE(point.has_value());
  EXPECT_TRUE(point->isApprox(Eigen::Vector3d(0.3, 0.4, 0)));
  EXPECT_FALSE(surface.Nearest({0.3, 0.4, 0.2}, 0.1).has_value());
  EXPECT_TRUE(surface.NormalAt({0.3, 0.4, 0.2}).isApprox(Eigen::Vector3d::UnitZ()));
}

TEST(FineSurfaceTest, CurvesAreTheBoundariesAndCreases) {
  TaggedMesh grid = {testing::OpenGrid(4), {}};
  for (int32_t x = 0; x < 4; ++x) grid.tags.edges.push_back({2 * 5 + x, 2 * 5 + x + 1});
  const FineSurface surface(grid);
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  EXPECT_TRUE(surface.NearestOnCurve({0.3, 0.45, 0}, x, 1)->isApprox(Eigen::Vector3d(0.3, 0.5, 0)));
  EXPECT_TRUE(surface.NearestOnCurve({0.3, 0.1, 0}, -x, 1)->isApprox(Eigen::Vector3d(0.3, 0, 0)));
  EXPECT_FALSE(surface.NearestOnCurve({0.3, 0.45, 0}, y, 1).has_value());  // runs across
  EXPECT_FALSE(surface.NearestOnCurve({0.3, 0.4, 0}, x, 0.05).has_value());
  EXPECT_FALSE(
      FineSurface({testing::Icosphere(1), {}}).NearestOnCurve({1, 0, 0}, x, 1).has_value());
}

}  // namespace
}  // namespace cagefit
