#include "core/template/quadric_collapse.h"

#include <gtest/gtest.h>

#include "core/mesh/topology.h"
#include "core/mesh/triangle_bvh.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

Topology TopologyOf(const TriangleMesh& mesh) {
  auto topology = Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles);
  EXPECT_TRUE(topology.ok()) << topology.status();
  return *std::move(topology);
}

TEST(QuadricCollapseTest, ReachesTheCountAndStaysClosed) {
  const TriangleMesh sphere = testing::Icosphere(4);
  const TriangleMesh coarse = CollapseEdges(sphere, 200);
  EXPECT_EQ(coarse.vertices.cols(), 200);
  EXPECT_EQ(coarse.triangles.cols(), 396);  // 2 V - 4: genus 0
  EXPECT_TRUE(TopologyOf(coarse).BoundaryLoops().empty());
  const TriangleBvh surface(coarse.vertices, coarse.triangles);
  double worst = 0;
  for (int64_t v = 0; v < sphere.vertices.cols(); ++v) {
    worst = std::max(worst, surface.Closest(sphere.vertices.col(v)).distance);
  }
  EXPECT_LT(worst, 0.03);
}

TEST(QuadricCollapseTest, KeepsGenusAndBoundaries) {
  const Topology torus = TopologyOf(CollapseEdges(testing::Torus(48, 24), 150));
  EXPECT_EQ(torus.vertex_count() - torus.edge_count() + torus.triangle_count(), 0);
  const TriangleMesh tube = CollapseEdges(testing::Tube(48, 40), 150);
  const Topology topology = TopologyOf(tube);
  ASSERT_EQ(topology.BoundaryLoops().size(), 2u);
  for (const auto& loop : topology.BoundaryLoops()) {
    for (const int32_t v : loop) {
      const double z = tube.vertices(2, v);
      EXPECT_LT(std::min(std::abs(z), std::abs(z - 2)), 1e-4);
    }
  }
}

TEST(QuadricCollapseTest, FlatRegionsLoseNoArea) {
  const TriangleMesh coarse = CollapseEdges(testing::OpenGrid(30), 40);
  const Topology topology = TopologyOf(coarse);
  EXPECT_LE(topology.vertex_count(), 41);
  double area = 0;
  for (int64_t f = 0; f < coarse.triangles.cols(); ++f) {
    const Eigen::Vector3d a = coarse.vertices.col(coarse.triangles(0, f));
    const Eigen::Vector3d ab = coarse.vertices.col(coarse.triangles(1, f)) - a;
    const Eigen::Vector3d ac = coarse.vertices.col(coarse.triangles(2, f)) - a;
    area += 0.5 * (ab[0] * ac[1] - ab[1] * ac[0]);  // signed: a turned triangle would show
  }
  EXPECT_NEAR(area, 1, 1e-3);
}

TEST(QuadricCollapseTest, StopsWhereTheTopologyNeedsMore) {
  const TriangleMesh least = CollapseEdges(testing::Icosphere(2), 1);
  EXPECT_GE(least.vertices.cols(), 4);
  TopologyOf(least);
}

}  // namespace
}  // namespace cagefit
