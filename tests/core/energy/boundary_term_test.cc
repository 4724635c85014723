#include "core/energy/boundary_term.h"

#include <gtest/gtest.h>

#include "core/mesh/control_mesh.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

// The unit square, its corners sharp so that the limit surface is the square.
ControlMesh Square(int cells) {
  const TriangleMesh mesh = testing::OpenGrid(cells);
  CreaseTags tags;
  for (int32_t v = 0; v < mesh.vertices.cols(); ++v) {
    const double x = mesh.vertices(0, v), y = mesh.vertices(1, v);
    if ((x == 0 || x == 1) && (y == 0 || y == 1)) tags.corners.push_back(v);
  }
  return *ControlMesh::Create(mesh.vertices, mesh.triangles, tags);
}

class BoundaryTermTest : public ::testing::Test {
 protected:
  double EnergyAt(const Points3d& V) {
    term_.Assign(V);
    return term_.attachments().Energy(V);
  }
  Points3d Shifted(double x, double y, double z) const {
    return cage_.vertices().colwise() + Eigen::Vector3d(x, y, z);
  }
  const ControlMesh cage_ = Square(8);
  const double n_ = static_cast<double>(cage_.vertex_count());
  BoundaryTerm term_{cage_.topology(), cage_.tags()};
  const BoundaryCurve curve_ = BoundaryOfMesh(testing::OpenGrid(8), 0.02);
};

TEST_F(BoundaryTermTest, IsTheMeanSquareAcrossTheBoundary) {
  term_.SetTarget(&curve_, 0.5);
  EXPECT_NEAR(EnergyAt(cage_.vertices()), 0, 1e-9);
  // Every point is off by 0.01.
  EXPECT_NEAR(EnergyAt(Shifted(0, 0, 0.01)), 0.5 * n_ * 1e-4, 1e-8);
  // A point where two sides meet may take either: half of the points, give or take the corners.
  const double sideways = EnergyAt(Shifted(0.01, 0, 0));
  EXPECT_NEAR(sideways, 0.5 * n_ * 0.5 * 1e-4, 0.5 * n_ * 1e-4 * 4 / 64);
}

TEST_F(BoundaryTermTest, WhatIsFarOrFacesAwayTakesNoPart) {
  term_.SetTarget(&curve_, 1);
  const double reach = BoundaryTerm::kReach * MeanEdgeLength(cage_.topology(), cage_.vertices());
  EXPECT_GT(EnergyAt(Shifted(0, 0, 0.99 * reach)), 0);
  EXPECT_EQ(EnergyAt(Shifted(0, 0, 1.01 * reach)), 0);
  BoundaryCurve turned = curve_;
  turned.normals = -turned.normals;
  term_.SetTarget(&turned, 1);
  EXPECT_EQ(EnergyAt(Shifted(0, 0, 0.01)), 0);
}

TEST_F(BoundaryTermTest, ChoicesAreHeldBetweenAssignments) {
  term_.SetTarget(&curve_, 1);
  const Points3d V = Shifted(0, 0, 0.01);
  const double there = EnergyAt(V);
  const double off = 10;  // out of reach, but nobody chose anew
  EXPECT_NEAR(term_.attachments().Energy(Shifted(0, 0, off)), there * off * off / 1e-4,
              1e-6 * there * off * off / 1e-4);
}

TEST_F(BoundaryTermTest, IsOffWithoutACurveAWeightOrABoundary) {
  term_.SetTarget(nullptr, 1);
  EXPECT_FALSE(term_.is_on());
  term_.SetTarget(&curve_, 0);
  EXPECT_FALSE(term_.is_on());
  term_.SetTarget(&curve_, 1);
  EXPECT_TRUE(term_.is_on());
  const TriangleMesh sphere = testing::Icosphere(1);
  const auto closed = ControlMesh::Create(sphere.vertices, sphere.triangles);
  BoundaryTerm of_closed(closed->topology(), {});
  of_closed.SetTarget(&curve_, 1);
  EXPECT_FALSE(of_closed.is_on());
  of_closed.Assign(closed->vertices());
  EXPECT_EQ(of_closed.attachments().Energy(closed->vertices()), 0);
}

}  // namespace
}  // namespace cagefit
