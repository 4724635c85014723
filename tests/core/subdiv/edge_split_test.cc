#include "core/subdiv/edge_split.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "core/mesh/triangle_bvh.h"
#include "core/subdiv/refine.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

ControlMesh Cage(const TriangleMesh& mesh, CreaseTags tags = {}) {
  return ControlMesh::Create(mesh.vertices, mesh.triangles, std::move(tags)).value();
}

std::vector<int32_t> AllEdges(const ControlMesh& mesh) {
  std::vector<int32_t> edges(mesh.topology().edge_count());
  std::iota(edges.begin(), edges.end(), 0);
  return edges;
}

std::vector<int32_t> RandomEdges(const ControlMesh& mesh, double share, uint32_t seed) {
  std::vector<int32_t> edges;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int32_t e = 0; e < mesh.topology().edge_count(); ++e) {
    if (uniform(random) < share) edges.push_back(e);
  }
  return edges;
}

// Points of the limit surface of `a`, three levels down, to the limit mesh of `b`.
double LargestDistance(const ControlMesh& a, const ControlMesh& b) {
  Points3d points, surface;
  ApplyStencils(BuildLimitMesh(a.topology(), a.tags(), 3).position, a.vertices(), &points);
  const LimitMesh limit = BuildLimitMesh(b.topology(), b.tags(), 4);
  ApplyStencils(limit.position, b.vertices(), &surface);
  const TriangleBvh bvh(surface, limit.triangles);
  double largest = 0;
  for (int64_t k = 0; k < points.cols(); ++k) {
    largest = std::max(largest, bvh.Closest(points.col(k)).distance);
  }
  return largest;
}

TEST(EdgeSplitTest, SplittingEveryEdgeIsLoopsRefinement) {
  for (const TriangleMesh& mesh :
       {testing::Icosphere(1), testing::Torus(12, 8), testing::OpenDisk(3)}) {
    const ControlMesh cage = Cage(mesh);
    const auto split = SplitEdges(cage, AllEdges(cage));
    ASSERT_TRUE(split.ok()) << split.status();
    const Refinement refined = RefineOnce(cage.topology(), cage.tags());
    EXPECT_EQ(split->triangles(), refined.topology.triangles());
    Points3d expected;
    ApplyStencils(refined.matrix, cage.vertices(), &expected);
    EXPECT_LT((split->vertices() - expected).cwiseAbs().maxCoeff(), 1e-14);
  }
}

TEST(EdgeSplitTest, EveryPatternKeepsTheMeshWhole) {
  for (const TriangleMesh& mesh :
       {testing::Icosphere(2), testing::Torus(12, 8), testing::OpenGrid(5), testing::Tube(8, 6),
        testing::MixedValences()}) {
    const ControlMesh cage = Cage(mesh);
    for (uint32_t seed = 0; seed < 20; ++seed) {
      const std::vector<int32_t> edges = RandomEdges(cage, 0.05 * seed, seed);
      const auto split = SplitEdges(cage, edges);
      ASSERT_TRUE(split.ok()) << split.status();
      EXPECT_EQ(split->vertex_count(), cage.vertex_count() + static_cast<int32_t>(edges.size()));
      EXPECT_EQ(split->topology().BoundaryLoops().size(), cage.topology().BoundaryLoops().size());
      // Euler's characteristic: an inner edge brings a vertex, three edges and two triangles.
      EXPECT_EQ(
          split->vertex_count() - split->topology().edge_count() +
              split->topology().triangle_count(),
          cage.vertex_count() - cage.topology().edge_count() + cage.topology().triangle_count());
    }
  }
}

// The same split with new vertices in the middle of their edges and old ones where they were.
ControlMesh WithMidpoints(const ControlMesh& cage, const std::vector<int32_t>& edges,
                          const ControlMesh& split) {
  Points3d V = split.vertices();
  V.leftCols(cage.vertex_count()) = cage.vertices();
  for (size_t k = 0; k < edges.size(); ++k) {
    const auto& [a, b] = cage.topology().edge(edges[k]);
    V.col(cage.vertex_count() + static_cast<int64_t>(k)) =
        0.5 * (cage.vertices().col(a) + cage.vertices().col(b));
  }
  return split.WithVertices(std::move(V));
}

TEST(EdgeSplitTest, TheLimitSurfaceHardlyChangesWhereARegionIsSplit) {
  const ControlMesh cage = Cage(testing::Icosphere(2));
  std::vector<int32_t> edges;
  for (int32_t e = 0; e < cage.topology().edge_count(); ++e) {
    const auto& [a, b] = cage.topology().edge(e);
    if (cage.vertices()(2, a) + cage.vertices()(2, b) > 0) edges.push_back(e);
  }
  const auto split = SplitEdges(cage, edges);
  ASSERT_TRUE(split.ok()) << split.status();
  // An edge is 0.3 long and bulges by 0.011; only at the border of the region does anything change.
  const double change = LargestDistance(cage, *split);
  EXPECT_LT(change, 0.004);
  EXPECT_LT(change, LargestDistance(cage, WithMidpoints(cage, edges, *split)) / 3);
}

TEST(EdgeSplitTest, OrderAndRepetitionOfTheEdgesDoNotMatter) {
  const ControlMesh cage = Cage(testing::Icosphere(1));
  const auto split = SplitEdges(cage, {3, 50, 17});
  const auto again = SplitEdges(cage, {17, 3, 50, 3});
  EXPECT_EQ(split->vertices(), again->vertices());
  EXPECT_EQ(split->triangles(), again->triangles());
  EXPECT_EQ(SplitEdges(cage, {})->triangles(), cage.triangles());
  EXPECT_EQ(SplitEdges(cage, {})->vertices(), cage.vertices());
}

TEST(EdgeSplitTest, BothHalvesOfACreaseAreCreasesAndCornersStay) {
  const TriangleMesh torus = testing::Torus(12, 8);
  const Topology topology = Topology::Create(96, torus.triangles).value();
  CreaseTags tags;
  tags.corners = {5, 40};
  for (int32_t e = 0; e < topology.edge_count(); e += 5) tags.edges.push_back(topology.edge(e));
  const ControlMesh cage = Cage(torus, tags);
  const std::vector<int32_t> edges = RandomEdges(cage, 0.5, 3);
  const auto split = SplitEdges(cage, edges);
  ASSERT_TRUE(split.ok()) << split.status();  // which finds every tagged edge in the mesh
  size_t halved = 0;
  for (const int32_t e : edges) halved += e % 5 == 0;
  EXPECT_GT(halved, 0u);
  EXPECT_EQ(split->tags().edges.size(), tags.edges.size() + halved);
  EXPECT_EQ(split->tags().corners, tags.corners);
  // Every half has one old end, and each old end has a half for each crease that it had.
  std::vector<int> degree(96, 0);
  for (const auto& [a, b] : tags.edges) ++degree[a], ++degree[b];
  for (const auto& [a, b] : split->tags().edges) {
    if (a < 96) --degree[a];
    if (b < 96) --degree[b];
  }
  EXPECT_THAT(degree, ::testing::Each(0));
}

TEST(EdgeSplitTest, ABoundaryCurveStaysWhereItWas) {
  const ControlMesh cage = Cage(testing::OpenDisk(4));
  std::vector<int32_t> rim;
  for (int32_t e = 0; e < cage.topology().edge_count(); ++e) {
    if (cage.topology().IsBoundaryEdge(e)) rim.push_back(e);
  }
  const auto split = SplitEdges(cage, rim);
  ASSERT_TRUE(split.ok()) << split.status();
  const auto loops = split->topology().BoundaryLoops();
  ASSERT_EQ(loops.size(), 1u);
  EXPECT_EQ(loops[0].size(), 2 * rim.size());
  // The whole rim is refined, so its cubic B-spline is the same curve: limits at the old vertices
  // agree.
  Points3d before, after;
  ApplyStencils(LimitPositionStencils(cage.topology(), {}), cage.vertices(), &before);
  ApplyStencils(LimitPositionStencils(split->topology(), {}), split->vertices(), &after);
  const auto loop = cage.topology().BoundaryLoops()[0];
  for (const int32_t v : loop) {
    EXPECT_LT((before.col(v) - after.col(v)).norm(), 1e-14);
  }
}

TEST(EdgeSplitTest, RepeatedLocalRefinementKeepsValencesLow) {
  // Ten rounds at one spot: without flips its valences would grow without bound.
  ControlMesh cage = Cage(testing::Icosphere(2));
  for (int round = 0; round < 10; ++round) {
    std::vector<int32_t> edges;
    for (int32_t e = 0; e < cage.topology().edge_count(); ++e) {
      const auto& [a, b] = cage.topology().edge(e);
      const double length = (cage.vertices().col(a) - cage.vertices().col(b)).norm();
      const Eigen::Vector3d middle = 0.5 * (cage.vertices().col(a) + cage.vertices().col(b));
      if ((middle - Eigen::Vector3d(0, 0, 1)).norm() < 2 * length) edges.push_back(e);
    }
    auto split = SplitEdges(cage, edges);
    ASSERT_TRUE(split.ok()) << split.status();
    cage = *std::move(split);
  }
  int32_t most = 0, near_regular = 0;
  for (int32_t v = 0; v < cage.vertex_count(); ++v) {
    most = std::max(most, cage.topology().Valence(v));
    near_regular += std::abs(cage.topology().Valence(v) - 6) <= 1;
  }
  EXPECT_LE(most, 9);
  EXPECT_GE(near_regular, 0.95 * cage.vertex_count());
}

}  // namespace
}  // namespace cagefit
