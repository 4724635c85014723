#include "server/session/flip_counter.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "tests/support/shapes.h"

namespace cagefit::server {
namespace {

using cagefit::testing::Icosphere;
using cagefit::testing::OpenGrid;

Points3d Turned(const Points3d& points) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  return turn * points;
}

// Two triangles over the common edge (0, 1); vertex 3 lies at `x` beside vertex 2 at 1.
Points3d Hinge(double x) {
  Points3d points(3, 4);
  points << 0, 0, 1, x,  //
      0, 1, 0, 0,        //
      0, 0, 0, 0;
  return points;
}

Triangles HingeTriangles() {
  Triangles triangles(3, 2);
  triangles << 1, 0,  //
      0, 1,           //
      2, 3;
  return triangles;
}

TEST(FlipCounterTest, TheTemplateItselfHasNone) {
  const TriangleMesh mesh = Icosphere(2);
  EXPECT_EQ(FlipCounter(mesh.triangles, mesh.vertices).Share(mesh.vertices), 0);
}

TEST(FlipCounterTest, ARotationOrSmallBendFlipsNothing) {
  const TriangleMesh mesh = Icosphere(2);
  const FlipCounter flips(mesh.triangles, mesh.vertices);
  EXPECT_EQ(flips.Share(Turned(mesh.vertices)), 0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> little(-0.02, 0.02);
  const Points3d bent = mesh.vertices + Points3d::NullaryExpr(3, mesh.vertices.cols(),
                                                              [&] { return little(random); });
  EXPECT_EQ(flips.Share(bent), 0);
}

TEST(FlipCounterTest, CountsBothSidesOfAFold) {
  const FlipCounter flips(HingeTriangles(), Hinge(-1));
  EXPECT_EQ(flips.Share(Hinge(-0.5)), 0);
  EXPECT_EQ(flips.Share(Hinge(0.5)), 1);
}

TEST(FlipCounterTest, AFoldOfTheTemplateIsNoFlip) {
  const FlipCounter flips(HingeTriangles(), Hinge(0.5));
  EXPECT_EQ(flips.Share(Hinge(0.7)), 0);
  EXPECT_EQ(flips.Share(Hinge(-1)), 0);
}

TEST(FlipCounterTest, CountsOnlyWhereTheSurfaceTurnedOver) {
  // The corner with a single triangle is pulled over that triangle's inner edge.
  TriangleMesh mesh = OpenGrid(4);
  const FlipCounter flips(mesh.triangles, mesh.vertices);
  std::vector<int> uses(mesh.vertices.cols(), 0);
  for (const int32_t vertex : mesh.triangles.reshaped()) ++uses[vertex];
  const auto corner = std::find(uses.begin(), uses.end(), 1) - uses.begin();
  mesh.vertices.col(corner) += 0.9 * (Eigen::Vector3d(0.5, 0.5, 0) - mesh.vertices.col(corner));
  EXPECT_DOUBLE_EQ(flips.Share(mesh.vertices), 1.0 / 32);
}

TEST(FlipCounterTest, NoTrianglesHaveNoFlips) {
  const FlipCounter flips(Triangles(3, 0), Points3d(3, 0));
  EXPECT_EQ(flips.Share(Points3d(3, 0)), 0);
}

}  // namespace
}  // namespace cagefit::server
