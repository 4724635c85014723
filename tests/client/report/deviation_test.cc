#include "client/report/deviation.h"

#include <gmock/gmock.h>

#include "tests/support/shapes.h"

namespace cagefit::client {
namespace {

using ::testing::DoubleNear;
using ::testing::Each;
using ::testing::Ge;
using ::testing::Le;

Geometry MeshOf(const TriangleMesh& mesh) {
  Geometry geometry;
  geometry.mesh = mesh;
  return geometry;
}

// Points of the unit sphere, with their normals or without.
Geometry SphereCloud(bool has_normals) {
  Geometry geometry;
  geometry.mesh.vertices = testing::Icosphere(5).vertices;
  if (has_normals) geometry.normals = geometry.mesh.vertices.cast<float>();
  return geometry;
}

TEST(DeviationTest, IsPositiveOutsideAndNegativeInside) {
  const TriangleMesh outside = testing::Icosphere(3, 1.02), inside = testing::Icosphere(3, 0.98);
  for (const Geometry& target :
       {MeshOf(testing::Icosphere(5)), SphereCloud(true), SphereCloud(false)}) {
    EXPECT_THAT(SurfaceDeviations(outside, target), Each(DoubleNear(0.02, 2e-3)));
    EXPECT_THAT(SurfaceDeviations(inside, target), Each(DoubleNear(-0.02, 2e-3)));
  }
}

TEST(DeviationTest, OfPointsHasTheSurfacesSign) {
  const Points3d points = testing::Icosphere(2).vertices;
  const TriangleMesh outside = testing::Icosphere(5, 1.02), inside = testing::Icosphere(5, 0.98);
  EXPECT_THAT(PointDeviations(points, outside, {outside.vertices, outside.triangles}),
              Each(DoubleNear(0.02, 1e-3)));
  EXPECT_THAT(PointDeviations(points, inside, {inside.vertices, inside.triangles}),
              Each(DoubleNear(-0.02, 1e-3)));
}

TEST(DeviationTest, BeyondABorderTheDistanceToThePointCounts) {
  Geometry target;  // the plane z = 0 up to x = 1
  const TriangleMesh grid = testing::OpenGrid(40);
  target.mesh.vertices = grid.vertices;
  target.normals = Points3f::Zero(3, grid.vertices.cols());
  target.normals.row(2).setOnes();
  TriangleMesh surface = testing::OpenGrid(2);
  surface.vertices.row(0).array() += 2;  // begins one unit beyond the border, in the same plane
  const std::vector<double> deviations = SurfaceDeviations(surface, target);
  std::vector<double> sizes;
  for (const double d : deviations) sizes.push_back(std::abs(d));
  EXPECT_THAT(sizes, Each(Ge(1 - 1e-6)));
  EXPECT_THAT(sizes, Each(Le(2 + 1e-6)));
}

}  // namespace
}  // namespace cagefit::client
