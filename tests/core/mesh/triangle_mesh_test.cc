#include "core/mesh/triangle_mesh.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

TEST(VertexNormalsTest, PointOutwardsOnASphere) {
  const TriangleMesh sphere = testing::Icosphere(3);
  const Points3d normals = VertexNormals(sphere);
  for (Eigen::Index v = 0; v < normals.cols(); ++v) {
    EXPECT_NEAR(normals.col(v).norm(), 1, 1e-14);
    EXPECT_GT(normals.col(v).dot(sphere.vertices.col(v)), 0.9999);
  }
}

TEST(VertexNormalsTest, AreWeightedByAngleNotByFaces) {
  // A cube corner: one side is cut in two triangles, yet the three sides weigh the same.
  TriangleMesh mesh;
  mesh.vertices.resize(3, 5);
  mesh.vertices << 0, 1, 0, 0, 1,  //
      0, 0, 1, 0, 1,               //
      0, 0, 0, 1, 0;
  mesh.triangles.resize(3, 4);
  mesh.triangles << 0, 0, 0, 0,  //
      1, 4, 2, 3,                //
      4, 2, 3, 1;
  const Eigen::Vector3d normal = VertexNormals(mesh).col(0);
  EXPECT_LT((normal - Eigen::Vector3d::Ones().normalized()).norm(), 1e-14);
}

TEST(VertexNormalsTest, AreZeroWithoutAFaceOfPositiveArea) {
  TriangleMesh mesh;
  mesh.vertices.resize(3, 4);
  mesh.vertices << 0, 1, 2, 5,  //
      0, 0, 0, 5,               //
      0, 0, 0, 5;
  mesh.triangles.resize(3, 1);
  mesh.triangles << 0, 1, 2;
  EXPECT_EQ(VertexNormals(mesh), Points3d::Zero(3, 4));
}

}  // namespace
}  // namespace cagefit
