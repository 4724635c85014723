#include "core/cloud/surface_cloud.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/cloud/kd_tree.h"
#include "core/metrics/surface_samples.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

// Largest distance from a point of the surface to the cloud.
double LargestGap(const TriangleMesh& mesh, const PointCloud& cloud) {
  const Points3d samples = SampleSurface(mesh, 20, 1);
  const KdTree tree(cloud.points);
  float largest = 0;
  for (int64_t i = 0; i < samples.cols(); ++i) {
    int32_t index = 0;
    float squared = 0;
    tree.Nearest(samples.col(i).cast<float>(), 1, &index, &squared);
    largest = std::max(largest, squared);
  }
  return std::sqrt(largest);
}

TEST(SurfaceCloudTest, AnEvenlyFineMeshGivesItsVerticesAndMiddles) {
  const TriangleMesh sphere = testing::Icosphere(5);
  const PointCloud cloud = SurfaceCloud(sphere, Points3f(3, 0));
  ASSERT_EQ(cloud.size(), sphere.vertices.cols() + sphere.triangles.cols());
  const Points3d middles = cloud.points.rightCols(sphere.triangles.cols()).cast<double>();
  for (int64_t f = 0; f < sphere.triangles.cols(); ++f) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (int c = 0; c < 3; ++c) middle += sphere.vertices.col(sphere.triangles(c, f)) / 3;
    EXPECT_LT((middles.col(f) - middle).norm(), 1e-6);
  }
}

TEST(SurfaceCloudTest, AVeryFineMeshGivesItsVerticesAlone) {
  const TriangleMesh sphere = testing::Icosphere(7);
  ASSERT_GT(sphere.triangles.cols(), 150'000);
  EXPECT_EQ(SurfaceCloud(sphere, Points3f(3, 0)).size(), sphere.vertices.cols());
}

TEST(SurfaceCloudTest, LargeTrianglesAreFilled) {
  // A fine sphere with a cap of its triangles replaced by one fan.
  TriangleMesh mesh = testing::Tube(100, 60);
  const int64_t n = mesh.vertices.cols(), f = mesh.triangles.cols();
  mesh.vertices.conservativeResize(3, n + 1);
  mesh.vertices.col(n) << 0, 0, 0;
  mesh.triangles.conservativeResize(3, f + 100);
  for (int k = 0; k < 100; ++k) mesh.triangles.col(f + k) << (k + 1) % 100, k, static_cast<int>(n);
  const PointCloud cloud = SurfaceCloud(mesh, Points3f(3, 0));
  EXPECT_LT(LargestGap(mesh, cloud), 0.06);
  const PointCloud bare = CloudFromMesh(mesh);
  EXPECT_GT(LargestGap(mesh, bare), 0.4);
  // Points of the cap look down.
  int64_t on_cap = 0;
  for (int64_t i = n + 1; i < cloud.size(); ++i) {
    if (cloud.points(2, i) > 1e-6f) continue;
    ++on_cap;
    EXPECT_LT(cloud.normals(2, i), -0.99f);
  }
  EXPECT_GT(on_cap, 300);
}

TEST(SurfaceCloudTest, AMeshOfFewTrianglesBecomesATarget) {
  const TriangleMesh box = testing::Icosphere(0);
  const PointCloud cloud = SurfaceCloud(box, Points3f(3, 0));
  EXPECT_GT(cloud.size(), 5'000);
  EXPECT_LE(cloud.size(), kFillOfSmallMesh + box.vertices.cols());
  EXPECT_NEAR(cloud.normals.colwise().norm().minCoeff(), 1, 1e-5);
}

TEST(SurfaceCloudTest, TheFillIsBounded) {
  // One enormous triangle beside a fine mesh.
  TriangleMesh mesh = testing::OpenGrid(100);
  const int64_t n = mesh.vertices.cols();
  mesh.vertices.conservativeResize(3, n + 3);
  mesh.vertices.rightCols(3) << 0, 1e6, 0, 0, 0, 1e6, 5, 5, 5;
  mesh.triangles.conservativeResize(3, mesh.triangles.cols() + 1);
  mesh.triangles.rightCols(1) << static_cast<int>(n), static_cast<int>(n) + 1,
      static_cast<int>(n) + 2;
  const PointCloud cloud = SurfaceCloud(mesh, Points3f(3, 0));
  EXPECT_LE(cloud.size(), (1 + kMaxFillPerVertex) * (n + 3));
  EXPECT_GT(cloud.size(), 2 * n);
}

TEST(SurfaceCloudTest, OwnNormalsAreTakenAndMadeUnit) {
  const TriangleMesh sphere = testing::Icosphere(5);
  const Points3f normals = -3 * sphere.vertices.cast<float>();
  const PointCloud cloud = SurfaceCloud(sphere, normals);
  const int64_t n = sphere.vertices.cols();
  EXPECT_TRUE(cloud.normals.leftCols(n).isApprox(-sphere.vertices.cast<float>(), 1e-5f));
}

}  // namespace
}  // namespace cagefit
