#include "client/report/display_mesh.h"

#include <gmock/gmock.h>

#include <set>

#include "core/subdiv/limit.h"
#include "tests/support/shapes.h"

namespace cagefit::client {
namespace {

ControlMesh CageOf(const TriangleMesh& mesh, CreaseTags tags = {}) {
  return ControlMesh::Create(mesh.vertices, mesh.triangles, std::move(tags)).value();
}

// Of the cube [0, 1]^3: edges whose ends lie on the same two faces.
CreaseTags CubeCreases(const TriangleMesh& cube) {
  const auto faces = [&](int32_t v) {
    std::set<int> on;
    for (int axis = 0; axis < 3; ++axis) {
      if (cube.vertices(axis, v) == 0) on.insert(2 * axis);
      if (cube.vertices(axis, v) == 1) on.insert(2 * axis + 1);
    }
    return on;
  };
  std::set<std::array<int32_t, 2>> edges;
  for (int64_t h = 0; h < cube.triangles.size(); ++h) {
    const int32_t a = cube.triangles.data()[h];
    const int32_t b = cube.triangles.data()[h % 3 == 2 ? h - 2 : h + 1];
    int common = 0;
    for (const int face : faces(a)) common += static_cast<int>(faces(b).count(face));
    if (common == 2) edges.insert({std::min(a, b), std::max(a, b)});
  }
  return {{edges.begin(), edges.end()}, {}};
}

TEST(DisplayMeshTest, RefinesAsFarAsTheLimitAllows) {
  const ControlMesh cage = CageOf(testing::Icosphere(1));  // 42, 162, 642, 2,562 vertices
  EXPECT_EQ(BuildDisplayMesh(cage, 41).levels, 0);
  EXPECT_EQ(BuildDisplayMesh(cage, 161).levels, 0);
  EXPECT_EQ(BuildDisplayMesh(cage, 162).levels, 1);
  EXPECT_EQ(BuildDisplayMesh(cage, 1'000'000).levels, 3);
  EXPECT_EQ(BuildDisplayMesh(cage, 642).position.rows(), 642);
}

TEST(DisplayMeshTest, DrawsTheLimitMesh) {
  const ControlMesh cage = CageOf(testing::Torus(8, 5));
  const DisplayMesh mesh = BuildDisplayMesh(cage, 200);
  ASSERT_EQ(mesh.levels, 1);
  const LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), 1);
  EXPECT_EQ(mesh.limit_triangles, limit.triangles);
  EXPECT_TRUE(mesh.position.isApprox(limit.position));
  EXPECT_EQ(mesh.limit_vertices.size(), 160u);
  for (int64_t h = 0; h < limit.triangles.size(); ++h) {
    EXPECT_EQ(mesh.limit_vertices[mesh.triangles.data()[h]], limit.triangles.data()[h]);
  }
  EXPECT_TRUE(mesh.creases.empty() && mesh.borders.empty());
}

TEST(DisplayMeshTest, DrawsBothSidesOfACrease) {
  const TriangleMesh cube = testing::Cube(2);
  const DisplayMesh mesh = BuildDisplayMesh(CageOf(cube, CubeCreases(cube)), 200);
  ASSERT_EQ(mesh.levels, 1);
  EXPECT_EQ(mesh.creases.size(), 48u);
  // 8 corners on three faces, and 12 x 3 vertices on two.
  EXPECT_EQ(static_cast<int64_t>(mesh.limit_vertices.size()),
            mesh.position.rows() + 8 * 2 + 12 * 3);
}

TEST(DisplayMeshTest, KnowsItsBorders) {
  const DisplayMesh mesh = BuildDisplayMesh(CageOf(testing::Tube(6, 4)), 120);
  ASSERT_EQ(mesh.levels, 1);
  EXPECT_EQ(mesh.borders.size(), 24u);
}

}  // namespace
}  // namespace cagefit::client
