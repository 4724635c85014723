#include "core/cloud/outliers.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/mesh_file.h"
#include "tests/support/shapes.h"
#include "tests/support/spoiled_cloud.h"

namespace cagefit {
namespace {

using testing::GridOf;
using testing::WithOutliers;

PointCloud SphereCloud() { return CloudFromMesh(testing::Icosphere(6)); }

std::vector<int32_t> OutliersOf(const PointCloud& cloud) { return FindOutliers(GridOf(cloud)); }

int64_t CountBelow(const std::vector<int32_t>& indices, int64_t limit) {
  return std::lower_bound(indices.begin(), indices.end(), limit) - indices.begin();
}

// Clumps of `size` points inside the unit sphere, far from it, behind the others.
PointCloud WithClumps(PointCloud cloud, int size, int clumps) {
  Random random(4);
  const int64_t clean = cloud.size();
  cloud.points.conservativeResize(3, clean + size * clumps);
  cloud.normals.conservativeResize(3, clean + size * clumps);
  for (int c = 0; c < clumps; ++c) {
    const Eigen::Vector3d direction = random.NormalVector().normalized();
    const Eigen::Vector3d centre = 0.85 * std::cbrt(random.Uniform()) * direction;
    for (int k = 0; k < size; ++k) {
      const int64_t i = clean + c * size + k;
      cloud.points.col(i) = (centre + 0.005 * random.NormalVector()).cast<float>();
      cloud.normals.col(i) = Eigen::Vector3f::UnitX();
    }
  }
  return cloud;
}

TEST(OutliersTest, AreNoneOnCleanSurfaces) {
  EXPECT_TRUE(OutliersOf(SphereCloud()).empty());
  EXPECT_TRUE(OutliersOf(CloudFromMesh(testing::Torus(200, 60))).empty());
  EXPECT_TRUE(OutliersOf(CloudFromMesh(testing::OpenGrid(100))).empty());
}

TEST(OutliersTest, FarFromTheSurfaceAreFoundAndNoPointOfItIs) {
  const PointCloud clean = SphereCloud();
  for (const double share : {0.001, 0.01, 0.1}) {
    const PointCloud cloud = WithOutliers(clean, share);
    const std::vector<int32_t> found = OutliersOf(cloud);
    EXPECT_EQ(CountBelow(found, clean.size()), 0);
    for (int64_t i = clean.size(); i < cloud.size(); ++i) {
      if (std::abs(cloud.points.col(i).norm() - 1) < 0.1) continue;
      EXPECT_TRUE(std::binary_search(found.begin(), found.end(), i)) << "point " << i;
    }
  }
}

TEST(OutliersTest, InSmallClumpsAreFoundToo) {
  const PointCloud clean = SphereCloud();
  for (const int size : {2, 3, 5}) {
    const std::vector<int32_t> found = OutliersOf(WithClumps(clean, size, 100));
    EXPECT_EQ(CountBelow(found, clean.size()), 0);
    // Some lie beside another, and the two together are no small clump.
    EXPECT_GT(static_cast<double>(found.size()), 0.85 * 100 * size) << size;
  }
}

// A hemisphere of an eighth of the other's density, and strays: the sparse one is no outlier.
TEST(OutliersTest, AreNoPointsOfASparsePartOfTheSurface) {
  const PointCloud dense = SphereCloud();
  PointCloud uneven = dense;
  Random random(5);
  int64_t kept = 0;
  for (int64_t i = 0; i < dense.size(); ++i) {
    if (dense.points(2, i) < 0 && random.Uniform() > 1.0 / 8) continue;
    uneven.points.col(kept) = dense.points.col(i);
    uneven.normals.col(kept++) = dense.normals.col(i);
  }
  uneven.points.conservativeResize(3, kept);
  uneven.normals.conservativeResize(3, kept);
  const PointCloud cloud = WithOutliers(uneven, 0.01);
  const std::vector<int32_t> found = OutliersOf(cloud);
  EXPECT_LT(CountBelow(found, kept), 0.005 * static_cast<double>(kept));
  EXPECT_GT(static_cast<double>(found.size()), 0.8 * static_cast<double>(cloud.size() - kept));
}

TEST(OutliersTest, AreFoundInCloudsWithoutNormals) {
  PointCloud cloud = WithOutliers(SphereCloud(), 0.05);
  const std::vector<int32_t> oriented = OutliersOf(cloud);
  cloud.normals.resize(3, 0);
  EXPECT_EQ(OutliersOf(cloud), oriented);
  EXPECT_FALSE(oriented.empty());
}

TEST(OutliersTest, AreTheSameForAnyNumberOfThreads) {
  const CellGrid grid = GridOf(WithOutliers(SphereCloud(), 0.1));
  const std::vector<int32_t> all = FindOutliers(grid);
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(FindOutliers(grid), all);
}

TEST(OutliersTest, AreNoneAmongTooFewPoints) {
  PointCloud cloud;
  cloud.points = Points3f::Random(3, kOutlierNeighbors);
  CellGrid grid;
  grid.Build(cloud, 1);
  EXPECT_TRUE(FindOutliers(grid).empty());
}

TEST(RemovePointsTest, KeepsTheOthersInOrderWithTheirNormals) {
  PointCloud cloud;
  cloud.points.resize(3, 5);
  cloud.points << 0, 1, 2, 3, 4, 0, 1, 2, 3, 4, 0, 1, 2, 3, 4;
  cloud.normals = -cloud.points;
  RemovePoints({0, 3}, &cloud);
  ASSERT_EQ(cloud.size(), 3);
  EXPECT_EQ(cloud.points.row(0), Eigen::RowVector3f(1, 2, 4));
  EXPECT_EQ(cloud.normals, -cloud.points);
}

TEST(OutliersOnRealDataTest, SpareRealPoints) {
  CAGEFIT_NEEDS_DATA();
  for (const char* name : {"bunny_closed_34835", "armadillo_49990", "fish_10786", "face_25905",
                           "fandisk_6475", "human_man_6890", "plane_holes_8519"}) {
    const PointCloud cloud =
        CloudFromMesh(testing::ReadTestMesh(std::string("static/") + name + ".ply"));
    EXPECT_TRUE(OutliersOf(cloud).empty()) << name;
    const std::vector<int32_t> found = OutliersOf(WithOutliers(cloud, 0.1));
    EXPECT_LT(CountBelow(found, cloud.size()), 0.002 * static_cast<double>(cloud.size())) << name;
    EXPECT_GT(static_cast<double>(found.size()), 0.05 * static_cast<double>(cloud.size())) << name;
  }
}

}  // namespace
}  // namespace cagefit
