#include "core/template/edge_split.h"

#include <gtest/gtest.h>

#include "core/mesh/crease_detection.h"
#include "core/mesh/topology.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

TEST(EdgeSplitTest, ReachesTheCountOnTheSurface) {
  const TaggedMesh fine = {testing::Icosphere(5), {}};
  TaggedMesh tagged = {testing::Icosphere(1), {}};  // 42
  SplitLongEdges(FineSurface(fine), 500, &tagged);
  EXPECT_EQ(tagged.mesh.vertices.cols(), 500);
  const auto topology = Topology::Create(500, tagged.mesh.triangles);
  ASSERT_TRUE(topology.ok()) << topology.status();
  EXPECT_TRUE(topology->BoundaryLoops().empty());
  EXPECT_NEAR(tagged.mesh.vertices.colwise().norm().minCoeff(), 1, 2e-3);
  double longest = 0;
  for (int32_t e = 0; e < topology->edge_count(); ++e) {
    const auto& [a, b] = topology->edge(e);
    longest = std::max(longest, (tagged.mesh.vertices.col(a) - tagged.mesh.vertices.col(b)).norm());
  }
  EXPECT_LT(longest, 0.35);  // 0.62 before
}

TEST(EdgeSplitTest, CreasesAndBoundariesAreSplitOnTheirCurves) {
  TaggedMesh cube = {testing::Cube(1), {}};
  const auto topology =
      Topology::Create(static_cast<int32_t>(cube.mesh.vertices.cols()), cube.mesh.triangles);
  ASSERT_TRUE(topology.ok()) << topology.status();
  cube.tags =
      DetectCreases(cube.mesh.vertices, *topology, kDefaultCreaseAngle, CreaseEffort::kAlways);
  ASSERT_EQ(cube.tags.edges.size(), 12u);
  SplitLongEdges(FineSurface(cube), 60, &cube);
  EXPECT_GT(cube.tags.edges.size(), 12u);
  const auto split = Topology::Create(60, cube.mesh.triangles);
  ASSERT_TRUE(split.ok()) << split.status();
  double length = 0;
  for (const auto& [a, b] : cube.tags.edges) {
    ASSERT_NE(split->FindEdge(a, b), Topology::kNone);
    length += (cube.mesh.vertices.col(a) - cube.mesh.vertices.col(b)).norm();
  }
  EXPECT_NEAR(length, 12, 1e-12);
}

}  // namespace
}  // namespace cagefit
