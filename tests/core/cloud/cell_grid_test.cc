#include "core/cloud/cell_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <vector>

namespace cagefit {
namespace {

PointCloud RandomCloud(int64_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  PointCloud cloud;
  cloud.points.resize(3, count);
  cloud.normals.resize(3, count);
  for (int64_t i = 0; i < count; ++i) {
    cloud.points.col(i) << uniform(random), uniform(random), 0.1f * uniform(random);
    cloud.normals.col(i) =
        Eigen::Vector3f(uniform(random), uniform(random), uniform(random)).normalized();
  }
  return cloud;
}

int CountWithin(const PointCloud& cloud, const Eigen::Vector3d& x, double radius) {
  int count = 0;
  for (int64_t i = 0; i < cloud.size(); ++i) {
    count += (cloud.points.col(i).cast<double>() - x).norm() <= radius;
  }
  return count;
}

TEST(CellGridTest, RunsHoldEveryPointWithinTheRadiusOnce) {
  const PointCloud cloud = RandomCloud(2000, 1);
  CellGrid grid;
  grid.Build(cloud, 0.15);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1.3, 1.3);
  for (const double radius : {0.01, 0.07, 0.3, 5.0}) {
    for (int q = 0; q < 50; ++q) {
      const Eigen::Vector3d x(uniform(random), uniform(random), uniform(random));
      int count = 0;
      std::vector<int32_t> seen;
      grid.ForEachRun(x, radius, [&](int32_t begin, int32_t end) {
        for (int32_t i = begin; i < end; ++i) {
          seen.push_back(i);
          const Eigen::Vector3d p(grid.point(0)[i], grid.point(1)[i], grid.point(2)[i]);
          count += (p - x).norm() <= radius;
        }
      });
      EXPECT_EQ(count, CountWithin(cloud, x, radius));
      std::sort(seen.begin(), seen.end());
      EXPECT_EQ(std::adjacent_find(seen.begin(), seen.end()), seen.end());
    }
  }
}

TEST(CellGridTest, KthDistanceAgreesWithSortingAll) {
  const PointCloud cloud = RandomCloud(500, 3);
  CellGrid grid;
  grid.Build(cloud, 0.05);
  std::vector<float> scratch;
  for (const Eigen::Vector3d& x :
       {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 0), Eigen::Vector3d(40, -3, 2)}) {
    std::vector<double> all;
    for (int64_t i = 0; i < cloud.size(); ++i) {
      all.push_back((cloud.points.col(i).cast<double>() - x).norm());
    }
    std::sort(all.begin(), all.end());
    for (const int k : {1, 7, 100, 500}) {
      EXPECT_NEAR(grid.KthDistance(x, k, &scratch), all[k - 1], 1e-5 * (1 + all[k - 1]));
    }
    EXPECT_EQ(grid.KthDistance(x, 501, &scratch), std::numeric_limits<double>::infinity());
  }
}

TEST(CellGridTest, LeavesOutPointsWhoseNormalHasNoDirection) {
  PointCloud cloud = RandomCloud(100, 4);
  cloud.normals.col(7).setZero();
  cloud.normals.col(99).setZero();
  cloud.normals.col(5) *= 3;
  CellGrid grid;
  grid.Build(cloud, 0.2);
  ASSERT_EQ(grid.size(), 98);
  for (int64_t i = 0; i < grid.size(); ++i) {
    EXPECT_NEAR(Eigen::Vector3f(grid.normal(0)[i], grid.normal(1)[i], grid.normal(2)[i]).norm(), 1,
                1e-6);
  }
}

TEST(CellGridTest, RebuildingForgetsTheCloudBefore) {
  CellGrid grid;
  grid.Build(RandomCloud(3000, 5), 0.05);
  grid.Build(RandomCloud(20, 6), 0.5);
  EXPECT_EQ(grid.size(), 20);
  int visited = 0;
  grid.ForEachRun(Eigen::Vector3d::Zero(), 10,
                  [&](int32_t begin, int32_t end) { visited += end - begin; });
  EXPECT_EQ(visited, 20);
}

}  // namespace
}  // namespace cagefit
