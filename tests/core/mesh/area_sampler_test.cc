#include "core/mesh/area_sampler.h"

#include <gtest/gtest.h>

namespace cagefit {
namespace {

// Two triangles in z = 0, the second nine times as large as the first.
const Points3d kVertices = (Points3d(3, 6) << 0, 1, 0, 10, 13, 10,  // x
                            0, 0, 1, 0, 0, 3,                       // y
                            0, 0, 0, 0, 0, 0)
                               .finished();
const Triangles kTriangles = (Triangles(3, 2) << 0, 3, 1, 4, 2, 5).finished();

TEST(AreaSamplerTest, LargerTrianglesAreDrawnMoreOften) {
  const AreaSampler sampler(kVertices, kTriangles);
  Random random(7);
  int second = 0;
  Eigen::Vector3d weights = Eigen::Vector3d::Zero();
  for (int k = 0; k < 40'000; ++k) {
    const AreaSampler::Point point = sampler.Draw(&random);
    second += point.triangle == 1;
    weights += point.weights / 40'000;
    ASSERT_GE(point.weights.minCoeff(), 0);
    ASSERT_NEAR(point.weights.sum(), 1, 1e-12);
  }
  EXPECT_NEAR(second / 40'000.0, 0.9, 0.01);
  // The mean of uniform points of a triangle is its middle.
  EXPECT_LT((weights.array() - 1.0 / 3).abs().maxCoeff(), 0.01);
}

TEST(AreaSamplerTest, SharesOfTheAreaNameTheTriangle) {
  const AreaSampler sampler(kVertices, kTriangles);
  Random random(7);
  EXPECT_EQ(sampler.DrawAt(0, &random).triangle, 0);
  EXPECT_EQ(sampler.DrawAt(0.0999, &random).triangle, 0);
  EXPECT_EQ(sampler.DrawAt(0.1001, &random).triangle, 1);
  EXPECT_EQ(sampler.DrawAt(1, &random).triangle, 1);
}

TEST(AreaSamplerTest, KnowsWhereThereIsNoArea) {
  EXPECT_FALSE(AreaSampler(Points3d::Zero(3, 6), kTriangles).has_area());
  EXPECT_FALSE(AreaSampler(kVertices, Triangles(3, 0)).has_area());
  EXPECT_TRUE(AreaSampler(kVertices, kTriangles).has_area());
}

}  // namespace
}  // namespace cagefit
