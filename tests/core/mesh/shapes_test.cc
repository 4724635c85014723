// The meshes that other tests build on are what they claim to be.
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <set>

#include "core/mesh/topology.h"

namespace cagefit::testing {
namespace {

struct Expected {
  const char* name;
  TriangleMesh mesh;
  int vertices, boundary_loops, euler_characteristic;
};

TEST(ShapesTest, HaveTheirTopology) {
  const Expected cases[] = {
      {"icosphere", Icosphere(2), 162, 0, 2}, {"grid", OpenGrid(4), 25, 1, 1},
      {"disk", OpenDisk(3), 37, 1, 1},        {"torus", Torus(12, 8), 96, 0, 0},
      {"tube", Tube(10, 5), 60, 2, 0},        {"mixed valences", MixedValences(), 162, 0, 2}};
  for (const Expected& expected : cases) {
    SCOPED_TRACE(expected.name);
    const auto topology = Topology::Create(static_cast<int32_t>(expected.mesh.vertices.cols()),
                                           expected.mesh.triangles);
    ASSERT_TRUE(topology.ok()) << topology.status();
    EXPECT_EQ(topology->vertex_count(), expected.vertices);
    EXPECT_EQ(topology->BoundaryLoops().size(), expected.boundary_loops);
    EXPECT_EQ(topology->vertex_count() - topology->edge_count() + topology->triangle_count(),
              expected.euler_characteristic);
  }
}

TEST(ShapesTest, MixedValencesCoverThreeToTwelve) {
  const TriangleMesh mesh = MixedValences();
  const auto topology =
      Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles);
  ASSERT_TRUE(topology.ok());
  std::set<int> valences;
  for (int32_t v = 0; v < topology->vertex_count(); ++v) valences.insert(topology->Valence(v));
  EXPECT_EQ(valences, (std::set<int>{3, 4, 5, 6, 7, 8, 9, 10, 11, 12}));
}

TEST(ShapesTest, ClosedShapesFaceOutwards) {
  for (const TriangleMesh& mesh : {Icosphere(1), Torus(12, 8)}) {
    double volume = 0;
    for (Eigen::Index f = 0; f < mesh.triangles.cols(); ++f) {
      Eigen::Matrix3d corners;
      for (int c = 0; c < 3; ++c) corners.col(c) = mesh.vertices.col(mesh.triangles(c, f));
      volume += corners.determinant() / 6;
    }
    EXPECT_GT(volume, 0);
  }
}

TEST(ShapesTest, OpenShapesFaceUpwardsAndOutwards) {
  for (const TriangleMesh& mesh : {OpenGrid(2), OpenDisk(2)}) {
    const Points3d normals = VertexNormals(mesh);
    for (Eigen::Index v = 0; v < normals.cols(); ++v) EXPECT_NEAR(normals(2, v), 1, 1e-12);
  }
  const TriangleMesh tube = Tube(10, 5);
  const Points3d normals = VertexNormals(tube);
  for (Eigen::Index v = 0; v < normals.cols(); ++v) {
    EXPECT_GT(normals.col(v).head<2>().dot(tube.vertices.col(v).head<2>()), 0.9);
  }
}

}  // namespace
}  // namespace cagefit::testing
