#include "core/fit/refinement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "tests/core/fit/fit_fixture.h"

namespace cagefit {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

// `points` target points at `distance` over each of the triangles.
TargetDistances Over(std::vector<int32_t> triangles, int points, double distance) {
  TargetDistances out;
  for (const int32_t f : triangles) {
    for (int k = 0; k < points; ++k) {
      out.triangle.push_back(f);
      out.distance.push_back(distance);
    }
  }
  return out;
}

RefinementLimits Limits(int32_t vertices = 1000) {
  RefinementLimits limits;
  limits.tolerance = 0.1;
  limits.ignore_beyond = 1;
  limits.vertices = vertices;
  return limits;
}

// An icosahedron, whose edges are all as long.
TEST(RefinementTest, SplitsTheLongestEdgesOfTrianglesWithPointsBeyondTolerance) {
  const ControlMesh cage = testing::SphereCage(0, 1);
  const auto edges = EdgesToSplit(cage, Over({7}, 1, 0.2), Limits());
  std::vector<int32_t> expected;
  for (int c = 0; c < 3; ++c) expected.push_back(cage.topology().triangle_edge(7, c));
  EXPECT_THAT(edges, ::testing::UnorderedElementsAreArray(expected));
  EXPECT_TRUE(std::is_sorted(edges.begin(), edges.end()));
}

TEST(RefinementTest, PointsWithinToleranceAndOutliersAskForNothing) {
  const ControlMesh cage = testing::SphereCage(1, 1);
  EXPECT_THAT(EdgesToSplit(cage, Over({7}, 5, 0.1), Limits()), IsEmpty());
  EXPECT_THAT(EdgesToSplit(cage, Over({7}, 5, 1.1), Limits()), IsEmpty());
}

TEST(RefinementTest, TheTriangleWithTheMostPointsComesFirst) {
  const ControlMesh cage = testing::SphereCage(0, 1);
  TargetDistances distances = Over({2}, 1, 0.2);
  const TargetDistances more = Over({15}, 3, 0.2);
  distances.triangle.insert(distances.triangle.end(), more.triangle.begin(), more.triangle.end());
  distances.distance.insert(distances.distance.end(), more.distance.begin(), more.distance.end());
  const auto edges = EdgesToSplit(cage, distances, Limits(/*vertices=*/3));
  std::vector<int32_t> expected;
  for (int c = 0; c < 3; ++c) expected.push_back(cage.topology().triangle_edge(15, c));
  EXPECT_THAT(edges, ::testing::UnorderedElementsAreArray(expected));
}

TEST(RefinementTest, OfANeedleOnlyTheLongEdgesAreSplit) {
  Points3d V(3, 3);
  V << 0, 1, 1,   //
      0, 0, 0.1,  //
      0, 0, 0;
  Triangles triangle(3, 1);
  triangle << 0, 1, 2;
  const ControlMesh needle = ControlMesh::Create(V, triangle).value();
  EXPECT_THAT(EdgesToSplit(needle, Over({0}, 1, 0.2), Limits()), ElementsAre(0, 2));
}

TEST(RefinementTest, ShortEdgesAreNotSplit) {
  const ControlMesh cage = testing::SphereCage(1, 1);
  RefinementLimits limits = Limits();
  limits.least_length = 10;
  EXPECT_THAT(EdgesToSplit(cage, Over({7}, 1, 0.2), limits), IsEmpty());
}

TEST(RefinementTest, SplittingAndRelaxingKeepsBoundariesAndCreases) {
  const TriangleMesh grid = testing::OpenGrid(6);
  CreaseTags tags;
  for (int32_t k = 0; k < 6; ++k) tags.edges.push_back({21 + k, 22 + k});  // across the middle
  const ControlMesh cage = ControlMesh::Create(grid.vertices, grid.triangles, tags).value();
  std::vector<int32_t> edges;
  for (int32_t e = 0; e < cage.topology().edge_count(); e += 2) edges.push_back(e);
  const auto split = SplitAndRelax(cage, edges);
  ASSERT_TRUE(split.ok()) << split.status();
  EXPECT_EQ(split->vertex_count(), cage.vertex_count() + static_cast<int32_t>(edges.size()));
  EXPECT_GT(split->tags().edges.size(), tags.edges.size());
  for (const auto& [a, b] : split->tags().edges) {
    EXPECT_NEAR(split->vertices()(1, a), 0.5, 1e-12);
    EXPECT_NEAR(split->vertices()(1, b), 0.5, 1e-12);
  }
  EXPECT_EQ(split->topology().BoundaryLoops().size(), 1u);
}

}  // namespace
}  // namespace cagefit
