#include "core/cloud/target_index.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cagefit {
namespace {

// A square lattice of side `step` in the plane z = 0.
PointCloud Lattice(int side, float step) {
  PointCloud cloud;
  cloud.points.resize(3, side * side);
  for (int i = 0; i < side * side; ++i) {
    cloud.points.col(i) << step * static_cast<float>(i % side), step * static_cast<float>(i / side),
        0;
  }
  cloud.normals = Eigen::Vector3f::UnitZ().replicate(1, side * side);
  return cloud;
}

TEST(TargetIndexTest, SpacingIsTheDistanceToTheSixthNeighbour) {
  const PointCloud cloud = Lattice(60, 0.01f);
  TargetIndex index;
  ASSERT_TRUE(index.Build(cloud, 0, 2).ok());
  // Four neighbours at one step, then the diagonal ones.
  EXPECT_NEAR(index.spacing(), 0.01 * std::sqrt(2), 1e-6);
  EXPECT_NEAR(index.radius(), 2 * index.spacing(), 1e-12);
}

TEST(TargetIndexTest, AGivenRadiusIsTaken) {
  const PointCloud cloud = Lattice(30, 0.01f);
  TargetIndex index;
  ASSERT_TRUE(index.Build(cloud, 0.5, 2).ok());
  EXPECT_EQ(index.radius(), 0.5);
}

TEST(TargetIndexTest, FindsTheNearestPoint) {
  const PointCloud cloud = Lattice(30, 0.01f);
  TargetIndex index;
  ASSERT_TRUE(index.Build(cloud, 0, 2).ok());
  EXPECT_EQ(index.Nearest(Eigen::Vector3d(0.052, 0.028, 4)), 30 * 3 + 5);
}

TEST(TargetIndexTest, RefusesACloudWithoutUsableNormals) {
  PointCloud cloud = Lattice(30, 0.01f);
  cloud.normals.setZero();
  TargetIndex index;
  EXPECT_EQ(index.Build(cloud, 0, 2).code(), absl::StatusCode::kInvalidArgument);
}

TEST(TargetIndexTest, RefusesACloudOfCoincidentPoints) {
  PointCloud cloud = Lattice(30, 0.01f);
  cloud.points.setZero();
  TargetIndex index;
  EXPECT_EQ(index.Build(cloud, 0, 2).code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace cagefit
