#include "core/template/mesh_repair.h"

#include <gtest/gtest.h>

#include "core/mesh/topology.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

// Each triangle with three vertices of its own, as in an STL file.
TriangleMesh Soup(const TriangleMesh& mesh) {
  TriangleMesh soup;
  soup.vertices.resize(3, 3 * mesh.triangles.cols());
  soup.triangles.resize(3, mesh.triangles.cols());
  for (int32_t k = 0; k < soup.vertices.cols(); ++k) {
    soup.vertices.col(k) = mesh.vertices.col(mesh.triangles(k % 3, k / 3));
    soup.triangles(k % 3, k / 3) = k;
  }
  return soup;
}

bool IsManifold(const TriangleMesh& mesh) {
  return Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles).ok();
}

TEST(MeshRepairTest, JoinsASoup) {
  const TriangleMesh sphere = testing::Icosphere(2);
  RepairReport report;
  const TriangleMesh joined = MakeManifold(Soup(sphere), &report);
  EXPECT_EQ(joined.vertices.cols(), sphere.vertices.cols());
  EXPECT_EQ(joined.triangles.cols(), sphere.triangles.cols());
  EXPECT_EQ(report.dropped_triangles, 0);
  EXPECT_TRUE(IsManifold(joined));
}

TEST(MeshRepairTest, DropsDoubledDegenerateAndThirdTriangles) {
  TriangleMesh mesh = testing::OpenGrid(2);
  const int64_t sound = mesh.triangles.cols();
  mesh.triangles.conservativeResize(3, sound + 3);
  mesh.triangles.col(sound) = mesh.triangles.col(0);  // doubled
  mesh.triangles.col(sound + 1) << 0, 1, 2;           // on a line
  mesh.triangles.col(sound + 2) << 0, 4, 6;           // a third one at the inner edge 0-4
  RepairReport report;
  const TriangleMesh repaired = MakeManifold(mesh, &report);
  EXPECT_EQ(repaired.triangles.cols(), sound);
  EXPECT_EQ(report.dropped_triangles, 3);
  EXPECT_TRUE(IsManifold(repaired));
}

TEST(MeshRepairTest, SplitsAVertexWhereTwoFansMeet) {
  TriangleMesh other = testing::OpenGrid(1);
  other.vertices.colwise() += Eigen::Vector3d(1, 1, 0);  // shares the corner (1, 1, 0)
  RepairReport report;
  const TriangleMesh repaired =
      MakeManifold(testing::Together(testing::OpenGrid(1), other), &report);
  EXPECT_EQ(repaired.triangles.cols(), 4);
  EXPECT_EQ(report.split_vertices, 1);
  EXPECT_TRUE(IsManifold(repaired));
}

TEST(MeshRepairTest, KeepsTheLargeComponents) {
  const TriangleMesh mesh =
      testing::Together(testing::Icosphere(2),
                        testing::Together(testing::Icosphere(1, 0.5), testing::Icosphere(1, 0.05)));
  int kept = 0, dropped = 0;
  const TriangleMesh large = KeepLargeComponents(mesh, 0.01, &kept, &dropped);
  EXPECT_EQ(kept, 2);
  EXPECT_EQ(dropped, 1);
  EXPECT_EQ(large.vertices.cols(), 162 + 42);
}

TEST(MeshRepairTest, SelectLeavesUnusedVerticesOut) {
  const TriangleMesh grid = testing::OpenGrid(2);
  std::vector<char> keep(grid.triangles.cols(), 0);
  keep[0] = 1;
  const TriangleMesh one = SelectTriangles(grid, keep);
  EXPECT_EQ(one.vertices.cols(), 3);
  EXPECT_EQ(one.triangles.cols(), 1);
}

TEST(MeshRepairTest, CapsAreFlippedWhereTheyLie) {
  // A vertex put into the middle of a cube's edge, but for a hair, by a cap on one side of it.
  TriangleMesh cube = testing::Cube(1);
  auto topology = Topology::Create(static_cast<int32_t>(cube.vertices.cols()), cube.triangles);
  ASSERT_TRUE(topology.ok());
  const auto [f, g] = topology->edge_triangles(0);
  const auto [a, b] = topology->edge(0);
  const int32_t m = static_cast<int32_t>(cube.vertices.cols());
  cube.vertices.conservativeResize(3, m + 1);
  cube.vertices.col(m) = 0.5 * (cube.vertices.col(a) + cube.vertices.col(b));
  const auto t = topology->triangles().col(f);
  int c = 0;
  while (topology->triangle_edge(f, c) != 0) ++c;
  const int32_t from = t[c], to = t[(c + 1) % 3], apex = t[(c + 2) % 3];
  cube.vertices.col(m) += 1e-4 * (cube.vertices.col(apex) - cube.vertices.col(m));
  const int64_t count = cube.triangles.cols();
  cube.triangles.conservativeResize(3, count + 2);
  cube.triangles.col(f) << from, to, m;  // the cap
  cube.triangles.col(count) << from, m, apex;
  cube.triangles.col(count + 1) << m, to, apex;
  FlipCaps(&cube);
  topology = Topology::Create(m + 1, cube.triangles);
  ASSERT_TRUE(topology.ok()) << topology.status();
  EXPECT_EQ(topology->FindEdge(a, b), Topology::kNone);
  EXPECT_NE(topology->FindEdge(a, m), Topology::kNone);
  EXPECT_NE(topology->FindEdge(b, m), Topology::kNone);
  EXPECT_TRUE(topology->BoundaryLoops().empty());
}

TEST(MeshRepairTest, ThinTrianglesOfAnotherShapeStay) {
  TriangleMesh sheet = testing::OpenGrid(4);
  sheet.vertices.row(0) *= 0.01;  // no caps, but no flip makes these better
  const TriangleMesh before = sheet;
  FlipCaps(&sheet);
  EXPECT_EQ(sheet.triangles, before.triangles);
}

}  // namespace
}  // namespace cagefit
