#include "core/cloud/repair_normals.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <string>

#include "tests/support/data.h"
#include "tests/support/mesh_file.h"
#include "tests/support/shapes.h"
#include "tests/support/spoiled_cloud.h"

namespace cagefit {
namespace {

using testing::GridOf;
using testing::WithFlippedNormals;
using testing::WithNoise;

PointCloud TorusCloud() { return CloudFromMesh(testing::Torus(300, 80)); }

// Two squares, back to back, at a tenth of the spacing of their points.
PointCloud ThinSheet() {
  PointCloud front = CloudFromMesh(testing::OpenGrid(100));
  PointCloud both;
  both.points.resize(3, 2 * front.size());
  both.normals.resize(3, 2 * front.size());
  const Eigen::Vector3f step(0.004f, 0.003f, 0.001f);
  both.points << front.points, front.points.colwise() - step;
  both.normals << front.normals, -front.normals;
  return both;
}

int64_t CountAgainst(const PointCloud& cloud, const PointCloud& truth) {
  return (cloud.normals.cwiseProduct(truth.normals).colwise().sum().array() < 0).count();
}

TEST(RepairNormalsTest, LeavesACleanCloudAlone) {
  PointCloud cloud = TorusCloud();
  const Points3f normals = cloud.normals;
  EXPECT_EQ(RepairNormals(GridOf(cloud), &cloud), 0);
  EXPECT_EQ(cloud.normals, normals);
}

TEST(RepairNormalsTest, TurnsBackNearlyAllOfOneInTwenty) {
  const PointCloud clean = TorusCloud();
  PointCloud cloud = WithFlippedNormals(clean, 0.05);
  const int64_t before = CountAgainst(cloud, clean);
  const int64_t turned = RepairNormals(GridOf(cloud), &cloud);
  EXPECT_LT(static_cast<double>(CountAgainst(cloud, clean)), 0.01 * static_cast<double>(before));
  EXPECT_NEAR(static_cast<double>(turned), static_cast<double>(before),
              0.01 * static_cast<double>(before));
}

TEST(RepairNormalsTest, TurnsBackMostOfOneInFive) {
  const PointCloud clean = TorusCloud();
  PointCloud cloud = WithFlippedNormals(clean, 0.2);
  const int64_t before = CountAgainst(cloud, clean);
  RepairNormals(GridOf(cloud), &cloud);
  EXPECT_LT(static_cast<double>(CountAgainst(cloud, clean)), 0.15 * static_cast<double>(before));
}

TEST(RepairNormalsTest, WorksUnderNoise) {
  const PointCloud clean = TorusCloud();
  PointCloud cloud = WithFlippedNormals(WithNoise(clean, 0.003), 0.05);
  const int64_t before = CountAgainst(cloud, clean);
  RepairNormals(GridOf(cloud), &cloud);
  EXPECT_LT(static_cast<double>(CountAgainst(cloud, clean)), 0.02 * static_cast<double>(before));
}

TEST(RepairNormalsTest, LeavesTheTwoSidesOfAThinSheetAlone) {
  PointCloud cloud = ThinSheet();
  EXPECT_EQ(RepairNormals(GridOf(cloud), &cloud), 0);
}

TEST(RepairNormalsTest, KeepsTheLengthOfNormals) {
  PointCloud cloud = WithFlippedNormals(TorusCloud(), 0.05);
  cloud.normals *= 2;
  RepairNormals(GridOf(cloud), &cloud);
  EXPECT_NEAR(cloud.normals.colwise().norm().maxCoeff(), 2, 1e-5);
}

TEST(RepairNormalsTest, IsTheSameForAnyNumberOfThreads) {
  PointCloud cloud = WithFlippedNormals(TorusCloud(), 0.1);
  PointCloud again = cloud;
  const CellGrid grid = GridOf(cloud);
  RepairNormals(grid, &cloud);
  tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  RepairNormals(grid, &again);
  EXPECT_EQ(cloud.normals, again.normals);
}

TEST(RepairNormalsOnRealDataTest, RestoresTheBunnyAndSparesFins) {
  CAGEFIT_NEEDS_DATA();
  for (const char* name : {"bunny_closed_34835", "fish_10786"}) {
    const PointCloud clean =
        CloudFromMesh(testing::ReadTestMesh(std::string("static/") + name + ".ply"));
    PointCloud cloud = clean;
    EXPECT_EQ(RepairNormals(GridOf(clean), &cloud), 0) << name;
    cloud = WithFlippedNormals(clean, 0.05);
    const int64_t before = CountAgainst(cloud, clean);
    RepairNormals(GridOf(cloud), &cloud);
    EXPECT_LT(static_cast<double>(CountAgainst(cloud, clean)), 0.02 * static_cast<double>(before))
        << name;
  }
}

}  // namespace
}  // namespace cagefit
