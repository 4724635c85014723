#include "core/mesh/topology.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

#include "tests/support/data.h"
#include "tests/support/mesh_file.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Triangles Faces(std::initializer_list<std::array<int32_t, 3>> faces) {
  Triangles triangles(3, static_cast<Eigen::Index>(faces.size()));
  Eigen::Index f = 0;
  for (const auto& face : faces) triangles.col(f++) << face[0], face[1], face[2];
  return triangles;
}

Topology Make(const TriangleMesh& mesh) {
  return *Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles);
}

std::string ErrorOf(int32_t vertex_count, const Triangles& triangles) {
  const auto topology = Topology::Create(vertex_count, triangles);
  if (topology.ok()) return "accepted";
  EXPECT_EQ(topology.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(topology.status().message());
}

// Every pair of neighbours in a ring, with the vertex, is a triangle of the mesh as it is oriented.
void ExpectRingsToBeOrderedFans(const Topology& topology) {
  std::set<std::array<int32_t, 3>> triangles;
  for (Eigen::Index f = 0; f < topology.triangle_count(); ++f) {
    const auto t = topology.triangles().col(f);
    for (int c = 0; c < 3; ++c) triangles.insert({t[c], t[(c + 1) % 3], t[(c + 2) % 3]});
  }
  size_t corners = 0;
  for (int32_t v = 0; v < topology.vertex_count(); ++v) {
    const auto ring = topology.Ring(v);
    const auto edges = topology.RingEdges(v);
    const size_t fan = topology.IsBoundaryVertex(v) ? ring.size() - 1 : ring.size();
    for (size_t k = 0; k < fan; ++k) {
      EXPECT_EQ(triangles.count({v, ring[k], ring[(k + 1) % ring.size()]}), 1u)
          << "vertex " << v << " at " << k;
    }
    for (size_t k = 0; k < ring.size(); ++k) {
      EXPECT_EQ(topology.edge(edges[k])[0], std::min(v, ring[k]));
      EXPECT_EQ(topology.edge(edges[k])[1], std::max(v, ring[k]));
    }
    corners += fan;
  }
  EXPECT_EQ(corners, 3 * static_cast<size_t>(topology.triangle_count()));
}

void ExpectEdgesToAgreeWithTriangles(const Topology& topology) {
  int32_t next_edge = 0;
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const int32_t e = topology.triangle_edge(f, c), h = 3 * f + c;
      const int32_t from = topology.triangles()(c, f), to = topology.triangles()((c + 1) % 3, f);
      EXPECT_LE(e, next_edge) << "edges are numbered in order of first appearance";
      next_edge = std::max(next_edge, e + 1);
      EXPECT_THAT(topology.edge(e), ElementsAre(std::min(from, to), std::max(from, to)));
      EXPECT_EQ(topology.FindEdge(from, to), e);
      EXPECT_EQ(topology.FindEdge(to, from), e);
      EXPECT_THAT(topology.edge_triangles(e), ::testing::Contains(f));
      const int32_t other = topology.opposite(h);
      EXPECT_EQ(other == Topology::kNone, topology.IsBoundaryEdge(e));
      if (other == Topology::kNone) continue;
      EXPECT_EQ(topology.opposite(other), h);
      EXPECT_EQ(topology.triangles()(other % 3, other / 3), to);
    }
  }
  EXPECT_EQ(next_edge, topology.edge_count());
}

TEST(TopologyTest, RingsAreOrderedFansOnEveryShape) {
  for (const TriangleMesh& mesh :
       {testing::Icosphere(1), testing::OpenGrid(4), testing::OpenDisk(3), testing::Torus(8, 5),
        testing::Tube(7, 3), testing::MixedValences()}) {
    ExpectRingsToBeOrderedFans(Make(mesh));
  }
}

TEST(TopologyTest, EdgesAgreeWithTrianglesOnEveryShape) {
  for (const TriangleMesh& mesh : {testing::OpenGrid(4), testing::Torus(8, 5), testing::Tube(7, 3),
                                   testing::MixedValences()}) {
    ExpectEdgesToAgreeWithTriangles(Make(mesh));
  }
}

TEST(TopologyTest, AcceptsASingleTriangle) {
  const auto topology = Topology::Create(3, Faces({{0, 1, 2}}));
  ASSERT_TRUE(topology.ok());
  EXPECT_THAT(topology->Ring(1), ElementsAre(2, 0));
  EXPECT_THAT(topology->BoundaryLoops(), ElementsAre(ElementsAre(0, 1, 2)));
}

TEST(TopologyTest, BoundaryRingsRunFromOneBoundaryNeighborToTheOther) {
  const Topology topology = Make(testing::OpenGrid(2));
  EXPECT_THAT(topology.Ring(1), ElementsAre(2, 5, 4, 0));
}

TEST(TopologyTest, BoundaryLoopsFollowTheirTriangles) {
  const Topology tube = Make(testing::Tube(4, 2));
  EXPECT_THAT(tube.BoundaryLoops(),
              ElementsAre(ElementsAre(0, 1, 2, 3), ElementsAre(8, 11, 10, 9)));
}

TEST(TopologyTest, CountsComponents) {
  const TriangleMesh sphere = testing::Icosphere(0);
  Triangles two(3, 40);
  two << sphere.triangles, (sphere.triangles.array() + 12).matrix();
  const auto topology = Topology::Create(24, two);
  ASSERT_TRUE(topology.ok());
  std::vector<int32_t> component;
  EXPECT_EQ(topology->Components(&component), 2);
  EXPECT_EQ(component[11], 0);
  EXPECT_EQ(component[12], 1);
}

TEST(TopologyTest, FindsNoEdgeBetweenStrangersOrOutOfRange) {
  const Topology topology = Make(testing::OpenGrid(2));
  EXPECT_EQ(topology.FindEdge(0, 8), Topology::kNone);
  EXPECT_EQ(topology.FindEdge(0, 0), Topology::kNone);
  EXPECT_EQ(topology.FindEdge(-1, 0), Topology::kNone);
  EXPECT_EQ(topology.FindEdge(0, 9), Topology::kNone);
}

TEST(TopologyTest, DoesNotDependOnTheOrderOfTriangles) {
  TriangleMesh mesh = testing::MixedValences();
  const Topology before = Make(mesh);
  std::vector<Eigen::Index> order(mesh.triangles.cols());
  for (size_t k = 0; k < order.size(); ++k) order[k] = static_cast<Eigen::Index>(k);
  std::shuffle(order.begin(), order.end(), std::mt19937(5));
  Triangles shuffled(3, mesh.triangles.cols());
  for (size_t k = 0; k < order.size(); ++k) {
    shuffled.col(static_cast<Eigen::Index>(k)) = mesh.triangles.col(order[k]);
  }
  mesh.triangles = shuffled;
  const Topology after = Make(mesh);
  for (int32_t v = 0; v < before.vertex_count(); ++v) {
    EXPECT_EQ(before.Valence(v), after.Valence(v));
  }
}

TEST(TopologyErrorTest, NamesAnIndexOutOfRange) {
  EXPECT_THAT(ErrorOf(3, Faces({{0, 1, 3}})), HasSubstr("triangle 0: vertex index 3"));
  EXPECT_THAT(ErrorOf(3, Faces({{0, 1, -1}})), HasSubstr("-1"));
  EXPECT_THAT(ErrorOf(3, Faces({{0, 1, 2147483647}})), HasSubstr("2147483647"));
}

TEST(TopologyErrorTest, NamesARepeatedVertex) {
  EXPECT_THAT(ErrorOf(3, Faces({{0, 1, 0}})), HasSubstr("triangle 0: vertex 0 appears twice"));
}

TEST(TopologyErrorTest, NamesAnEdgeOfThreeTriangles) {
  EXPECT_THAT(ErrorOf(5, Faces({{0, 1, 2}, {1, 0, 3}, {0, 1, 4}})), HasSubstr("edge (0, 1)"));
}

TEST(TopologyErrorTest, NamesTrianglesOfOppositeOrientation) {
  EXPECT_THAT(ErrorOf(4, Faces({{0, 1, 2}, {0, 1, 3}})), HasSubstr("triangles 0 and 1"));
}

TEST(TopologyErrorTest, NamesATriangleGivenTwice) {
  EXPECT_THAT(ErrorOf(3, Faces({{0, 1, 2}, {1, 2, 0}})), HasSubstr("triangles 0 and 1"));
}

TEST(TopologyErrorTest, NamesAVertexOfTwoOpenFans) {
  EXPECT_THAT(ErrorOf(5, Faces({{0, 1, 2}, {0, 3, 4}})), HasSubstr("vertex 0"));
}

TEST(TopologyErrorTest, NamesAVertexOfTwoClosedFans) {
  // Two tetrahedra that share vertex 0.
  EXPECT_THAT(ErrorOf(7, Faces({{0, 2, 1},
                                {0, 1, 3},
                                {1, 2, 3},
                                {2, 0, 3},
                                {0, 5, 4},
                                {0, 4, 6},
                                {4, 5, 6},
                                {5, 0, 6}})),
              HasSubstr("vertex 0"));
}

TEST(TopologyErrorTest, NamesAVertexOfAnOpenAndAClosedFan) {
  EXPECT_THAT(ErrorOf(6, Faces({{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 4, 5}})),
              HasSubstr("vertex 0"));
}

TEST(TopologyErrorTest, NamesAnUnusedVertex) {
  EXPECT_THAT(ErrorOf(4, Faces({{0, 1, 2}})), HasSubstr("vertex 3"));
}

TEST(TopologyErrorTest, RefusesAnEmptyMesh) {
  EXPECT_THAT(ErrorOf(0, Triangles(3, 0)), HasSubstr("0 vertices and 0 triangles"));
  EXPECT_THAT(ErrorOf(3, Triangles(3, 0)), HasSubstr("3 vertices and 0 triangles"));
}

struct DataMesh {
  const char* name;
  int boundary_loops;
  int components;
};

TEST(TopologyDataTest, RealMeshesHaveTheBoundariesThatTheirManifestGives) {
  CAGEFIT_NEEDS_DATA();
  const DataMesh meshes[] = {
      {"static/face_25905.ply", 1, 1},       {"static/hemisphere_1861.ply", 1, 1},
      {"static/torus_2304.ply", 0, 1},       {"static/plane_holes_8519.ply", 27, 1},
      {"static/cgal_knot2.ply", 0, 2},       {"tshirt/template.ply", 4, 1},
      {"control/hand_lowres_810.obj", 1, 1}, {"control/bunny_314.obj", 0, 1}};
  for (const DataMesh& expected : meshes) {
    SCOPED_TRACE(expected.name);
    const TriangleMesh mesh = testing::ReadTestMesh(expected.name);
    const auto topology =
        Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles);
    ASSERT_TRUE(topology.ok()) << topology.status();
    std::vector<int32_t> component;
    EXPECT_EQ(topology->BoundaryLoops().size(), expected.boundary_loops);
    EXPECT_EQ(topology->Components(&component), expected.components);
  }
}

}  // namespace
}  // namespace cagefit
