#include "core/mesh/tangential_relax.h"

#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

double LengthSpread(const ControlMesh& mesh) {
  double least = 1e300, most = 0;
  for (int32_t e = 0; e < mesh.topology().edge_count(); ++e) {
    const auto& [a, b] = mesh.topology().edge(e);
    const double length = (mesh.vertices().col(a) - mesh.vertices().col(b)).norm();
    least = std::min(least, length);
    most = std::max(most, length);
  }
  return most / least;
}

// A mesh whose inner vertices were pushed about within z = 0.
ControlMesh UnevenGrid() {
  const TriangleMesh grid = testing::OpenGrid(8);
  Points3d V = grid.vertices;
  const Topology topology =
      Topology::Create(static_cast<int32_t>(V.cols()), grid.triangles).value();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.04, 0.04);
  for (int32_t v = 0; v < V.cols(); ++v) {
    if (!topology.IsBoundaryVertex(v))
      V.col(v) += Eigen::Vector3d(uniform(random), uniform(random), 0);
  }
  return ControlMesh::Create(std::move(V), grid.triangles).value();
}

TEST(TangentialRelaxTest, EvensOutAPlaneAndStaysInIt) {
  const ControlMesh uneven = UnevenGrid();
  const ControlMesh relaxed = RelaxTangentially(uneven, 5);
  EXPECT_LT(LengthSpread(relaxed), 0.8 * LengthSpread(uneven));
  EXPECT_LT(relaxed.vertices().row(2).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(TangentialRelaxTest, BoundariesCreasesAndCornersStay) {
  const ControlMesh uneven = UnevenGrid();
  CreaseTags tags;
  tags.edges = {{uneven.topology().Ring(40)[0], 40}};
  tags.corners = {20};
  const ControlMesh tagged =
      ControlMesh::Create(uneven.vertices(), uneven.triangles(), tags).value();
  const ControlMesh relaxed = RelaxTangentially(tagged, 3);
  int moved = 0;
  for (int32_t v = 0; v < tagged.vertex_count(); ++v) {
    const bool same = relaxed.vertices().col(v) == tagged.vertices().col(v);
    moved += !same;
    const bool fixed =
        tagged.topology().IsBoundaryVertex(v) || v == 40 || v == tags.edges[0][0] || v == 20;
    EXPECT_EQ(same, fixed) << v;
  }
  EXPECT_GT(moved, 0);
}

TEST(TangentialRelaxTest, ASphereKeepsItsSize) {
  // The normal part of the step is left out, without which the sphere would shrink by 4 %.
  const TriangleMesh sphere = testing::Icosphere(2);
  const ControlMesh mesh = ControlMesh::Create(sphere.vertices, sphere.triangles).value();
  const Points3d V = RelaxTangentially(mesh, 5).vertices();
  for (int64_t v = 0; v < V.cols(); ++v) EXPECT_NEAR(V.col(v).norm(), 1, 2e-3);
}

}  // namespace
}  // namespace cagefit
