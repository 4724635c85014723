#include "core/cloud/point_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

PointCloud CloudOf(int64_t count) {
  PointCloud cloud;
  cloud.points = Points3f::Constant(3, count, 0.5f);
  cloud.normals = Eigen::Vector3f::UnitZ().replicate(1, count);
  return cloud;
}

std::string ErrorOf(const PointCloud& cloud) {
  const absl::Status status = ValidateTarget(cloud);
  if (status.ok()) return "accepted";
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  return std::string(status.message());
}

TEST(ValidateTargetTest, AcceptsPointsWithAndWithoutNormals) {
  PointCloud cloud = CloudOf(kMinTargetPoints);
  EXPECT_EQ(ErrorOf(cloud), "accepted");
  cloud.normals.resize(3, 0);
  EXPECT_EQ(ErrorOf(cloud), "accepted");
}

TEST(ValidateTargetTest, NamesTheNumberOfTooFewPoints) {
  EXPECT_THAT(ErrorOf(CloudOf(0)), HasSubstr("points: 0"));
  EXPECT_THAT(ErrorOf(CloudOf(kMinTargetPoints - 1)),
              AllOf(HasSubstr("points: 15"), HasSubstr("16")));
}

TEST(ValidateTargetTest, NamesTheNumbersOfPointsAndNormalsThatDiffer) {
  PointCloud cloud = CloudOf(20);
  cloud.normals.conservativeResize(3, 19);
  EXPECT_THAT(ErrorOf(cloud), HasSubstr("normals: 19 for 20 points"));
}

TEST(ValidateTargetTest, NamesTheFirstPointThatIsNotFinite) {
  PointCloud cloud = CloudOf(20);
  cloud.points(1, 13) = std::numeric_limits<float>::quiet_NaN();
  cloud.points(2, 17) = std::numeric_limits<float>::infinity();
  EXPECT_THAT(ErrorOf(cloud), HasSubstr("point 13: (0.5, nan, 0.5)"));
}

TEST(ValidateTargetTest, RefusesInfinityInAnyCoordinateOfAnyPoint) {
  for (int64_t k = 0; k < 3 * 20; ++k) {
    PointCloud cloud = CloudOf(20);
    cloud.points.data()[k] = -std::numeric_limits<float>::infinity();
    EXPECT_THAT(ErrorOf(cloud), HasSubstr("point " + std::to_string(k / 3) + ":"));
  }
}

TEST(ValidateTargetTest, NamesTheFirstNormalThatIsNotFinite) {
  PointCloud cloud = CloudOf(20);
  cloud.normals(0, 19) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(ErrorOf(cloud), HasSubstr("normal 19"));
}

TEST(CloudFromMeshTest, NormalsOfASpherePointOutwards) {
  const TriangleMesh sphere = testing::Icosphere(3, 2);
  const PointCloud cloud = CloudFromMesh(sphere);
  ASSERT_EQ(cloud.size(), sphere.vertices.cols());
  EXPECT_EQ(cloud.points, sphere.vertices.cast<float>());
  for (int64_t i = 0; i < cloud.size(); ++i) {
    EXPECT_NEAR(cloud.normals.col(i).norm(), 1, 1e-6);
    EXPECT_GT(cloud.normals.col(i).dot(cloud.points.col(i) / 2), 0.999) << "point " << i;
  }
}

TEST(CloudFromMeshTest, LeavesOutUnreferencedVertices) {
  const TriangleMesh grid = testing::OpenGrid(4);
  const int64_t used = grid.vertices.cols();
  // One before and two behind the vertices of the grid.
  TriangleMesh mesh;
  mesh.vertices = Points3d::Constant(3, used + 3, 9);
  mesh.vertices.middleCols(1, used) = grid.vertices;
  mesh.triangles = grid.triangles.array() + 1;
  const PointCloud cloud = CloudFromMesh(mesh);
  ASSERT_EQ(cloud.size(), used);
  EXPECT_EQ(cloud.points, grid.vertices.cast<float>());
  EXPECT_TRUE(cloud.normals.isApprox(Eigen::Vector3f::UnitZ().replicate(1, used)));
}

TEST(CloudFromMeshTest, LeavesOutVerticesWhoseTrianglesHaveNoArea) {
  TriangleMesh mesh = testing::OpenGrid(4);
  const int64_t used = mesh.vertices.cols(), faces = mesh.triangles.cols();
  mesh.vertices.conservativeResize(3, used + 3);
  mesh.triangles.conservativeResize(3, faces + 1);
  for (int32_t k = 0; k < 3; ++k) {
    mesh.vertices.col(used + k) << 5, k, 0;  // in a row
    mesh.triangles(k, faces) = static_cast<int32_t>(used) + k;
  }
  EXPECT_EQ(CloudFromMesh(mesh).size(), used);
}

TEST(CloudFromMeshTest, AMeshWithoutTrianglesGivesAnEmptyCloud) {
  const PointCloud cloud = CloudFromMesh({Points3d::Ones(3, 5), Triangles(3, 0)});
  EXPECT_EQ(cloud.size(), 0);
  EXPECT_EQ(cloud.normals.cols(), 0);
}

}  // namespace
}  // namespace cagefit
