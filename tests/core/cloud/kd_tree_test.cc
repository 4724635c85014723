#include "core/cloud/kd_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

namespace cagefit {
namespace {

Points3f RandomPoints(int64_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  return Points3f::NullaryExpr(3, count, [&] { return uniform(random); });
}

std::vector<float> SquaredDistances(const Points3f& points, const Eigen::Vector3f& x) {
  std::vector<float> squared(points.cols());
  for (int64_t i = 0; i < points.cols(); ++i) squared[i] = (points.col(i) - x).squaredNorm();
  return squared;
}

void ExpectNearestToBeThoseOfBruteForce(const Points3f& points, const Eigen::Vector3f& x, int k) {
  const KdTree tree(points);
  std::vector<int32_t> indices(k, -1);
  std::vector<float> squared(k, -1);
  const int found = tree.Nearest(x, k, indices.data(), squared.data());
  const std::vector<float> all = SquaredDistances(points, x);
  std::vector<float> sorted = all;
  std::sort(sorted.begin(), sorted.end());
  ASSERT_EQ(found, std::min<int64_t>(k, points.cols()));
  for (int j = 0; j < found; ++j) {
    EXPECT_NEAR(squared[j], sorted[j], 1e-6f * (1 + sorted[j])) << "neighbour " << j;
    EXPECT_NEAR(squared[j], all[indices[j]], 1e-6f * (1 + all[indices[j]])) << "neighbour " << j;
  }
  std::sort(indices.begin(), indices.begin() + found);
  EXPECT_EQ(std::adjacent_find(indices.begin(), indices.begin() + found), indices.begin() + found);
}

TEST(KdTreeTest, FindsWhatBruteForceFinds) {
  const Points3f points = RandomPoints(3000, 1), queries = RandomPoints(50, 2);
  for (int64_t q = 0; q < queries.cols(); ++q) {
    for (const int k : {1, 7, 40}) {
      SCOPED_TRACE(k);
      ExpectNearestToBeThoseOfBruteForce(points, 1.5f * queries.col(q), k);
    }
  }
}

TEST(KdTreeTest, FindsThemFromFarAway) {
  ExpectNearestToBeThoseOfBruteForce(RandomPoints(500, 3), Eigen::Vector3f(30, -40, 5), 5);
}

TEST(KdTreeTest, APointIsItsOwnNearest) {
  const Points3f points = RandomPoints(500, 4);
  const KdTree tree(points);
  for (int64_t i = 0; i < points.cols(); ++i) {
    int32_t index;
    float squared;
    ASSERT_EQ(tree.Nearest(points.col(i), 1, &index, &squared), 1);
    EXPECT_EQ(index, i);
    EXPECT_EQ(squared, 0);
  }
}

TEST(KdTreeTest, FindsAllPointsOfAFlatCloudWithDuplicates) {
  Points3f points = RandomPoints(200, 5);
  points.row(2).setZero();
  points.rightCols(100) = points.leftCols(100);
  ExpectNearestToBeThoseOfBruteForce(points, Eigen::Vector3f(0.1f, 0.2f, 0.3f), 200);
}

TEST(KdTreeTest, ReturnsAllPointsWhenThereAreFewerThanAskedFor) {
  ExpectNearestToBeThoseOfBruteForce(RandomPoints(4, 6), Eigen::Vector3f::Zero(), 10);
}

TEST(KdTreeTest, FindsNothingInAnEmptyCloud) {
  const Points3f points(3, 0);
  const KdTree tree(points);
  int32_t index = -7;
  float squared;
  EXPECT_EQ(tree.Nearest(Eigen::Vector3f::Zero(), 1, &index, &squared), 0);
  EXPECT_EQ(index, -7);
}

TEST(KdTreeTest, WorksAfterAMove) {
  const Points3f points = RandomPoints(100, 7);
  KdTree from(points);
  const KdTree tree(std::move(from));
  int32_t index;
  float squared;
  ASSERT_EQ(tree.Nearest(points.col(42), 1, &index, &squared), 1);
  EXPECT_EQ(index, 42);
}

}  // namespace
}  // namespace cagefit
