#include "core/fit/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tests/core/fit/fit_fixture.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

const Eigen::Vector3d kAxes(0.5, 0.35, 0.2);

TriangleMesh Ellipsoid() {
  TriangleMesh mesh = testing::Icosphere(3);
  mesh.vertices = kAxes.asDiagonal() * mesh.vertices;
  return mesh;
}

Similarity Motion(double scale, double degrees, const Eigen::Vector3d& translation) {
  Similarity T;
  T.scale = scale;
  T.rotation = Eigen::AngleAxisd(degrees * M_PI / 180, Eigen::Vector3d(1, 2, -1).normalized())
                   .toRotationMatrix();
  T.translation = translation;
  return T;
}

TriangleMesh Moved(TriangleMesh mesh, const Similarity& T) {
  mesh.vertices = T * mesh.vertices;
  return mesh;
}

// Largest distance of a vertex of `mesh`, moved by the alignment, from where Ellipsoid() has it.
double Error(const TriangleMesh& mesh, const PointCloud& target) {
  const Similarity T = AlignToTarget(mesh, target);
  return (T * mesh.vertices - Ellipsoid().vertices).colwise().norm().maxCoeff();
}

TEST(AlignmentTest, ASimilarityComposesAndInverts) {
  const Similarity T = Motion(1.3, 20, {0.1, 0.2, 0.3});
  const Eigen::Vector3d x(0.4, -0.1, 0.7);
  EXPECT_NEAR((T.Inverse(T * x) - x).norm(), 0, 1e-15);
  EXPECT_FALSE(T.is_identity());
  EXPECT_TRUE(Similarity().is_identity());
}

TEST(AlignmentTest, FindsASurfaceThatWasShiftedScaledAndTurned) {
  const PointCloud target = testing::EllipsoidCloud(8000, kAxes);
  EXPECT_LT(Error(Moved(Ellipsoid(), Motion(1, 0, {0.3, 0.2, 0.2})), target), 0.005);
  EXPECT_LT(Error(Moved(Ellipsoid(), Motion(1.3, 0, {0, 0, 0})), target), 0.005);
  EXPECT_LT(Error(Moved(Ellipsoid(), Motion(0.7, 0, {0, 0, 0})), target), 0.005);
  EXPECT_LT(Error(Moved(Ellipsoid(), Motion(1, 20, {0, 0, 0})), target), 0.005);
  EXPECT_LT(Error(Moved(Ellipsoid(), Motion(1.3, 20, {0.3, -0.2, 0.2})), target), 0.005);
}

TEST(AlignmentTest, PartOfTheTargetIsEnough) {
  // Three quarters of it: its centroid and spread are not those of the surface.
  PointCloud target = testing::EllipsoidCloud(8000, kAxes);
  target.points.conservativeResize(3, 6000);
  target.normals.conservativeResize(3, 6000);
  EXPECT_LT(Error(Moved(Ellipsoid(), Motion(1, 15, {0.1, 0.05, 0.1})), target), 0.02);
}

TEST(AlignmentTest, ANearSurfaceStays) {
  const PointCloud target = testing::EllipsoidCloud(8000, kAxes);
  EXPECT_TRUE(AlignToTarget(Ellipsoid(), target).is_identity());
  // One that has to bend, too.
  TriangleMesh bent = Ellipsoid();
  for (int64_t v = 0; v < bent.vertices.cols(); ++v) {
    bent.vertices(2, v) += 0.3 * bent.vertices(0, v) * bent.vertices(0, v);
  }
  const Similarity T = AlignToTarget(bent, target);
  EXPECT_LT((T * bent.vertices - bent.vertices).colwise().norm().maxCoeff(), 0.1);
}

double RigidError(const TriangleMesh& mesh, const PointCloud& target) {
  const Similarity T = AlignRigidly(mesh, target);
  EXPECT_EQ(T.scale, 1);
  return (T * mesh.vertices - Ellipsoid().vertices).colwise().norm().maxCoeff();
}

TEST(AlignmentTest, ARigidMotionIsFoundAndTheSizeKept) {
  const PointCloud target = testing::EllipsoidCloud(8000, kAxes);
  EXPECT_LT(RigidError(Moved(Ellipsoid(), Motion(1, 20, {0, 0, 0})), target), 0.01);
  EXPECT_LT(RigidError(Moved(Ellipsoid(), Motion(1, 20, {0.3, -0.2, 0.2})), target), 0.01);
}

TEST(AlignmentTest, HalfOfTheTargetDoesNotDrawTheSurfaceToItsCentroid) {
  PointCloud target = testing::EllipsoidCloud(8000, kAxes);
  target.points.conservativeResize(3, 4000);  // in order of z
  target.normals.conservativeResize(3, 4000);
  EXPECT_LT(RigidError(Moved(Ellipsoid(), Motion(1, 5, {0.03, 0, 0.02})), target), 0.05);
}

TEST(AlignmentTest, ASurfaceWithoutAreaStays) {
  TriangleMesh flat;
  flat.vertices = Points3d::Zero(3, 3);
  flat.triangles.resize(3, 1);
  flat.triangles << 0, 1, 2;
  EXPECT_TRUE(AlignToTarget(flat, testing::EllipsoidCloud(1000, kAxes)).is_identity());
  EXPECT_TRUE(AlignRigidly(flat, testing::EllipsoidCloud(1000, kAxes)).is_identity());
}

}  // namespace
}  // namespace cagefit
