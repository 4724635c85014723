#include "core/template/needle_removal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh/topology.h"
#include "core/mesh/triangle_quality.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

double LeastQuality(const TriangleMesh& mesh) {
  double least = 1;
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    const auto t = mesh.triangles.col(f);
    least = std::min(least, TriangleQuality(mesh.vertices.col(t[0]), mesh.vertices.col(t[1]),
                                            mesh.vertices.col(t[2])));
  }
  return least;
}

Topology TopologyOf(const TriangleMesh& mesh) {
  auto topology = Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles);
  EXPECT_TRUE(topology.ok()) << topology.status();
  return *std::move(topology);
}

// The grid's line y = 0.5 as a crease, from side to side.
TaggedMesh CreasedGrid() {
  TaggedMesh tagged = {testing::OpenGrid(6), {}};
  for (int32_t x = 0; x < 6; ++x) tagged.tags.edges.push_back({3 * 7 + x, 3 * 7 + x + 1});
  return tagged;
}

void ExpectCreaseFromSideToSide(const TaggedMesh& tagged) {
  const Topology topology = TopologyOf(tagged.mesh);
  double length = 0;
  for (const auto& [a, b] : tagged.tags.edges) {
    ASSERT_NE(topology.FindEdge(a, b), Topology::kNone);
    EXPECT_NEAR(tagged.mesh.vertices(1, a), 0.5, 1e-12);
    EXPECT_NEAR(tagged.mesh.vertices(1, b), 0.5, 1e-12);
    length += (tagged.mesh.vertices.col(a) - tagged.mesh.vertices.col(b)).norm();
  }
  EXPECT_NEAR(length, 1, 1e-9);
}

TEST(NeedleRemovalTest, AShortEdgeCollapses) {
  TaggedMesh tagged = {testing::OpenGrid(6), {}};
  const FineSurface surface(tagged);
  const int32_t a = 3 * 7 + 3, b = a + 1;
  tagged.mesh.vertices.col(b) = tagged.mesh.vertices.col(a) + Eigen::Vector3d(0.001, 0, 0);
  ASSERT_LT(LeastQuality(tagged.mesh), 0.02);
  RemoveNeedles(surface, 0.3, &tagged);
  EXPECT_GT(LeastQuality(tagged.mesh), 0.3);
  EXPECT_EQ(TopologyOf(tagged.mesh).BoundaryLoops().size(), 1u);
}

TEST(NeedleRemovalTest, AVertexCloseToACreaseIsTakenUpOrMovesAway) {
  for (const double gap : {0.002, -0.002}) {
    TaggedMesh tagged = CreasedGrid();
    const FineSurface surface(tagged);
    const int32_t v = (gap > 0 ? 4 : 2) * 7 + 3;
    tagged.mesh.vertices.col(v) << 0.58, 0.5 + gap, 0;
    ASSERT_LT(LeastQuality(tagged.mesh), 0.1);
    RemoveNeedles(surface, 0.3, &tagged);
    EXPECT_GT(LeastQuality(tagged.mesh), 0.2);
    ExpectCreaseFromSideToSide(tagged);
  }
}

TEST(NeedleRemovalTest, AShortEdgeOfACreaseCollapsesAlongIt) {
  TaggedMesh tagged = CreasedGrid();
  const FineSurface surface(tagged);
  tagged.mesh.vertices(0, 3 * 7 + 3) = tagged.mesh.vertices(0, 3 * 7 + 4) - 0.003;
  RemoveNeedles(surface, 0.3, &tagged);
  EXPECT_GT(LeastQuality(tagged.mesh), 0.2);
  EXPECT_EQ(tagged.tags.edges.size(), 5u);
  ExpectCreaseFromSideToSide(tagged);
}

TEST(NeedleRemovalTest, AVertexCloseToTheBoundaryBecomesPartOfIt) {
  TaggedMesh tagged = {testing::OpenGrid(6), {}};
  const FineSurface surface(tagged);
  tagged.mesh.vertices.col(7 + 3) << 0.41, 0.001, 0;
  ASSERT_LT(LeastQuality(tagged.mesh), 0.1);
  RemoveNeedles(surface, 0.3, &tagged);
  EXPECT_GT(LeastQuality(tagged.mesh), 0.2);
  const Topology topology = TopologyOf(tagged.mesh);
  const std::vector<std::vector<int32_t>> loops = topology.BoundaryLoops();
  ASSERT_EQ(loops.size(), 1u);
  for (const int32_t v : loops[0]) {
    const Eigen::Array2d at = tagged.mesh.vertices.col(v).head<2>().array();
    EXPECT_NEAR((at - 0.5).abs().maxCoeff(), 0.5, 1e-12);
  }
}

TEST(NeedleRemovalTest, GoodMeshesStayAsTheyAre) {
  TaggedMesh tagged = {testing::Icosphere(3), {}};
  const TriangleMesh before = tagged.mesh;
  RemoveNeedles(FineSurface(tagged), 0.3, &tagged);
  EXPECT_EQ(tagged.mesh.vertices, before.vertices);
  EXPECT_EQ(tagged.mesh.triangles, before.triangles);
}

}  // namespace
}  // namespace cagefit
