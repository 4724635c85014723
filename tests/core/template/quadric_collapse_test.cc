#include "core/template/quadric_collapse.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/mesh/crease_detection.h"
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
  const TriangleMesh coarse = CollapseEdges({sphere, {}}, 200).mesh;
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
  const Topology torus = TopologyOf(CollapseEdges({testing::Torus(48, 24), {}}, 150).mesh);
  EXPECT_EQ(torus.vertex_count() - torus.edge_count() + torus.triangle_count(), 0);
  const TriangleMesh tube = CollapseEdges({testing::Tube(48, 40), {}}, 150).mesh;
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
  const TriangleMesh coarse = CollapseEdges({testing::OpenGrid(30), {}}, 40).mesh;
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
  const TriangleMesh least = CollapseEdges({testing::Icosphere(2), {}}, 1).mesh;
  EXPECT_GE(least.vertices.cols(), 4);
  TopologyOf(least);
}

// The tagged mesh of a shape with creases.
TaggedMesh WithCreases(const TriangleMesh& mesh) {
  return {mesh, DetectCreases(mesh.vertices, TopologyOf(mesh), kDefaultCreaseAngle,
                              CreaseEffort::kOnParts)};
}

TEST(QuadricCollapseTest, CornersStayAndCreasesStayOnTheirCurve) {
  const TaggedMesh coarse = CollapseEdges(WithCreases(testing::Cube(16)), 120);
  EXPECT_EQ(coarse.mesh.vertices.cols(), 120);
  const Points3d& V = coarse.mesh.vertices;
  ASSERT_EQ(coarse.tags.corners.size(), 8u);
  for (const int32_t v : coarse.tags.corners) {
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(std::abs(V(axis, v) - 0.5), 0.5, 1e-12) << V.col(v).transpose();
    }
  }
  // The creases are the cube's twelve edges, each covered once.
  const Topology topology = TopologyOf(coarse.mesh);
  double length = 0;
  for (const auto& [a, b] : coarse.tags.edges) {
    ASSERT_NE(topology.FindEdge(a, b), Topology::kNone);
    length += (V.col(a) - V.col(b)).norm();
    const Eigen::Array3d middle = 0.5 * (V.col(a) + V.col(b)).array();
    EXPECT_GE(((middle - 0.5).abs() > 0.5 - 1e-5).count(), 2) << middle.transpose();
  }
  EXPECT_NEAR(length, 12, 1e-5);
}

TEST(QuadricCollapseTest, RoundCreasesStayClosedCurves) {
  const TaggedMesh coarse = CollapseEdges(WithCreases(testing::Drum(12)), 100);
  std::vector<int> creases(coarse.mesh.vertices.cols(), 0);
  for (const auto& edge : coarse.tags.edges) {
    for (const int32_t v : edge) {
      ++creases[v];
      EXPECT_NEAR(coarse.mesh.vertices.col(v).head<2>().norm(), 1, 0.02);
      EXPECT_NEAR(std::abs(coarse.mesh.vertices(2, v) - 1), 1, 1e-3);
    }
  }
  EXPECT_GE(coarse.tags.edges.size(), 2u * 6);
  EXPECT_EQ(std::count(creases.begin(), creases.end(), 1), 0);  // no loose end
  EXPECT_EQ(std::count(creases.begin(), creases.end(), 2),
            static_cast<int64_t>(coarse.tags.edges.size()));
}

}  // namespace
}  // namespace cagefit
