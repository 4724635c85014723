#include "core/template/mesh_relax.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/mesh/crease_detection.h"
#include "core/mesh/topology.h"
#include "core/template/quadric_collapse.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

double MeanSquaredValenceError(const TriangleMesh& mesh) {
  const auto topology =
      Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles);
  EXPECT_TRUE(topology.ok()) << topology.status();
  double sum = 0;
  for (int32_t v = 0; v < topology->vertex_count(); ++v) {
    sum += std::pow(topology->Valence(v) - 6, 2);
  }
  return sum / topology->vertex_count();
}

double LeastQuality(const TriangleMesh& mesh) {
  double least = 1;
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    const Eigen::Vector3d a = mesh.vertices.col(mesh.triangles(0, f)),
                          b = mesh.vertices.col(mesh.triangles(1, f)),
                          c = mesh.vertices.col(mesh.triangles(2, f));
    const double sides = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
    least = std::min(least, 2 * std::sqrt(3.0) * (b - a).cross(c - a).norm() / sides);
  }
  return least;
}

TEST(MeshRelaxTest, EvensValencesAndStaysOnTheSurface) {
  const TriangleMesh fine = testing::Icosphere(5);
  TaggedMesh tagged = CollapseEdges({fine, {}}, 500);
  const TriangleMesh& mesh = tagged.mesh;
  const double before = MeanSquaredValenceError(mesh), quality = LeastQuality(mesh);
  RelaxMesh(FineSurface({fine, {}}), 5, &tagged);
  EXPECT_LT(MeanSquaredValenceError(mesh), 0.7 * before);
  EXPECT_GT(LeastQuality(mesh), quality);
  EXPECT_NEAR(mesh.vertices.colwise().norm().minCoeff(), 1, 2e-3);
  EXPECT_NEAR(mesh.vertices.colwise().norm().maxCoeff(), 1, 2e-3);
}

TEST(MeshRelaxTest, LeavesTheBoundaryWhereItIs) {
  TaggedMesh tagged = {testing::OpenGrid(6), {}};
  TriangleMesh& mesh = tagged.mesh;
  for (int v = 0; v < mesh.vertices.cols(); ++v) {
    const bool inner = v % 7 > 0 && v % 7 < 6 && v / 7 > 0 && v / 7 < 6;
    if (inner) mesh.vertices(0, v) += 0.06 * std::sin(7.0 * v);
  }
  const TriangleMesh before = mesh, flat = testing::OpenGrid(1);
  RelaxMesh(FineSurface({flat, {}}), 5, &tagged);
  for (int v = 0; v < 7; ++v) EXPECT_EQ(mesh.vertices.col(v), before.vertices.col(v));
  EXPECT_GT(LeastQuality(mesh), LeastQuality(before));
}

TEST(MeshRelaxTest, CreasesStayOnTheirCurve) {
  const TriangleMesh cube = testing::Cube(12);
  const auto topology =
      Topology::Create(static_cast<int32_t>(cube.vertices.cols()), cube.triangles);
  ASSERT_TRUE(topology.ok());
  const TaggedMesh fine = {
      cube, DetectCreases(cube.vertices, *topology, kDefaultCreaseAngle, CreaseEffort::kOnParts)};
  const TaggedMesh before = CollapseEdges(fine, 150);
  TaggedMesh mesh = before;
  RelaxMesh(FineSurface(fine), 5, &mesh);
  const auto relaxed =
      Topology::Create(static_cast<int32_t>(mesh.mesh.vertices.cols()), mesh.mesh.triangles);
  ASSERT_TRUE(relaxed.ok());
  EXPECT_EQ(mesh.tags.edges, before.tags.edges);
  for (const auto& [a, b] : mesh.tags.edges) {
    EXPECT_NE(relaxed->FindEdge(a, b), Topology::kNone);
    const Eigen::Array3d at = mesh.mesh.vertices.col(a).array();
    EXPECT_GE(((at - 0.5).abs() > 0.5 - 1e-5).count(), 2) << at.transpose();
  }
  for (const int32_t v : mesh.tags.corners) {
    EXPECT_EQ(mesh.mesh.vertices.col(v), before.mesh.vertices.col(v));
  }
  EXPECT_NE(mesh.mesh.vertices, before.mesh.vertices);
}

TEST(MeshRelaxTest, BoundariesBecomeEvenWhereTheirTrianglesAreThin) {
  TaggedMesh tagged = {testing::OpenGrid(6), {}};
  const FineSurface surface(tagged);
  TriangleMesh& mesh = tagged.mesh;
  mesh.vertices(0, 3) -= 0.15;  // along the side y = 0
  const double before = LeastQuality(mesh);
  RelaxMesh(surface, 5, &tagged);
  EXPECT_GT(LeastQuality(mesh), 1.5 * before);
  EXPECT_EQ(mesh.vertices(1, 3), 0);
}

}  // namespace
}  // namespace cagefit
