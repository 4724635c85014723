#include "core/mesh/valence_flips.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <vector>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

Triangles Flipped(const TriangleMesh& mesh, const CreaseTags& tags = {}, bool movable = true) {
  Triangles triangles = mesh.triangles;
  FlipTowardsRegularValence(mesh.vertices, tags,
                            std::vector<char>(triangles.cols(), movable ? 1 : 0), &triangles);
  return triangles;
}

int64_t Deviation(const Topology& topology) {
  int64_t sum = 0;
  for (int32_t v = 0; v < topology.vertex_count(); ++v) {
    const int64_t d = topology.Valence(v) - (topology.IsBoundaryVertex(v) ? 4 : 6);
    sum += d * d;
  }
  return sum;
}

Topology TopologyOf(const TriangleMesh& mesh, const Triangles& triangles) {
  return Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), triangles).value();
}

// A flat grid, whose vertices 6 and 12 exchanged an edge with their neighbours.
TriangleMesh DisturbedGrid() {
  TriangleMesh grid = testing::OpenGrid(8);
  const Topology topology = TopologyOf(grid, grid.triangles);
  for (int32_t f = 0; f < topology.triangle_count(); f += 14) {
    const int32_t g = topology.opposite(3 * f + 1) / 3;
    if (topology.opposite(3 * f + 1) == Topology::kNone) continue;
    const int32_t a = grid.triangles(1, f), b = grid.triangles(2, f), c = grid.triangles(0, f);
    int32_t d = -1;
    for (int k = 0; k < 3; ++k) {
      if (grid.triangles(k, g) != a && grid.triangles(k, g) != b) d = grid.triangles(k, g);
    }
    if (topology.IsBoundaryVertex(a) || topology.IsBoundaryVertex(b)) continue;
    grid.triangles.col(f) << a, d, c;
    grid.triangles.col(g) << d, b, c;
  }
  return grid;
}

TEST(ValenceFlipsTest, MakesADisturbedGridMoreRegular) {
  const TriangleMesh grid = DisturbedGrid();
  const Topology before = TopologyOf(grid, grid.triangles);
  const Topology after = TopologyOf(grid, Flipped(grid));
  EXPECT_GT(Deviation(before),
            Deviation(TopologyOf(testing::OpenGrid(8), testing::OpenGrid(8).triangles)));
  EXPECT_LT(Deviation(after), Deviation(before));
  EXPECT_EQ(after.edge_count(), before.edge_count());
  EXPECT_EQ(after.BoundaryLoops(), before.BoundaryLoops());
}

TEST(ValenceFlipsTest, LeavesARegularMeshAsItIs) {
  const TriangleMesh torus = testing::Torus(24, 12);
  EXPECT_EQ(Flipped(torus), torus.triangles);
  const TriangleMesh sphere = testing::Icosphere(3);
  EXPECT_EQ(Flipped(sphere), sphere.triangles);
}

TEST(ValenceFlipsTest, AMeshOfAllValencesStaysManifoldAndComesNearer) {
  const TriangleMesh mesh = testing::MixedValences();
  const Topology before = TopologyOf(mesh, mesh.triangles), after = TopologyOf(mesh, Flipped(mesh));
  EXPECT_LT(Deviation(after), Deviation(before));
  EXPECT_TRUE(ControlMesh::Create(mesh.vertices, after.triangles()).ok());
}

TEST(ValenceFlipsTest, CreasesStay) {
  const TriangleMesh mesh = testing::MixedValences();
  const Topology before = TopologyOf(mesh, mesh.triangles);
  CreaseTags tags;
  for (int32_t e = 0; e < before.edge_count(); e += 3) tags.edges.push_back(before.edge(e));
  const Topology after = TopologyOf(mesh, Flipped(mesh, tags));
  for (const auto& [a, b] : tags.edges) EXPECT_NE(after.FindEdge(a, b), Topology::kNone);
  EXPECT_NE(after.triangles(), before.triangles());
}

TEST(ValenceFlipsTest, OnlyMovableTrianglesChange) {
  const TriangleMesh mesh = testing::MixedValences();
  EXPECT_EQ(Flipped(mesh, {}, /*movable=*/false), mesh.triangles);
}

TEST(ValenceFlipsTest, AFoldIsNotFlippedAway) {
  // A grid folded along a diagonal by a right angle: flipping any edge of the fold would cut it.
  TriangleMesh grid = DisturbedGrid();
  for (int64_t v = 0; v < grid.vertices.cols(); ++v) {
    const double over = grid.vertices(0, v) + grid.vertices(1, v) - 1;
    if (over > 1e-9) grid.vertices(2, v) = 10 * over;
  }
  const Topology after = TopologyOf(grid, Flipped(grid));
  for (int32_t e = 0; e < after.edge_count(); ++e) {
    if (after.IsBoundaryEdge(e)) continue;
    const auto& [a, b] = after.edge(e);
    const bool was = TopologyOf(grid, grid.triangles).FindEdge(a, b) != Topology::kNone;
    const double over_a = grid.vertices(0, a) + grid.vertices(1, a) - 1;
    const double over_b = grid.vertices(0, b) + grid.vertices(1, b) - 1;
    EXPECT_TRUE(was || over_a * over_b > -1e-12) << "an edge across the fold is new";
  }
}

}  // namespace
}  // namespace cagefit
