#include "core/subdiv/shaded_mesh.h"

#include <gtest/gtest.h>

#include <set>

#include "core/mesh/triangle_mesh.h"
#include "core/subdiv/limit.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

ControlMesh Cage(const TriangleMesh& mesh, const CreaseTags& tags = {}) {
  return ControlMesh::Create(mesh.vertices, mesh.triangles, tags).value();
}

// The twelve edges of the unit cube, and its eight corners.
ControlMesh SharpCube(int cells) {
  const TriangleMesh cube = testing::Cube(cells);
  const auto walls = [&](int32_t v) {  // how many of the cube's faces v lies on
    int count = 0;
    for (const double x : cube.vertices.col(v)) count += x == 0 || x == 1;
    return count;
  };
  CreaseTags tags;
  const Topology topology =
      Topology::Create(static_cast<int32_t>(cube.vertices.cols()), cube.triangles).value();
  for (int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto& [a, b] = topology.edge(e);
    const Eigen::Vector3d middle = (cube.vertices.col(a) + cube.vertices.col(b)) / 2;
    const auto on_walls = (middle.array() == 0 || middle.array() == 1).count();
    if (on_walls == 2) tags.edges.push_back({a, b});
  }
  for (int32_t v = 0; v < topology.vertex_count(); ++v) {
    if (walls(v) == 3) tags.corners.push_back(v);
  }
  return Cage(cube, tags);
}

TEST(ShadedMeshTest, ASmoothSurfaceHasTheVerticesOfItsLimitMesh) {
  const ControlMesh cage = Cage(testing::MixedValences());
  for (const int levels : {0, 1, 2}) {
    const ShadedMesh shaded(cage, levels);
    const LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), levels);
    Points3d expected, positions, normals;
    ApplyStencils(limit.position, cage.vertices(), &expected);
    shaded.Evaluate(cage.vertices(), &positions, &normals);
    ASSERT_EQ(positions.cols(), expected.cols());
    EXPECT_EQ(shaded.limit_triangles(), limit.triangles);
    for (Eigen::Index h = 0; h < limit.triangles.size(); ++h) {
      EXPECT_EQ(positions.col(shaded.triangles().data()[h]),
                expected.col(limit.triangles.data()[h]));
    }
  }
}

// Largest distance of its normals from those of meshes refined further, whose vertices keep their
// numbers.
double DistanceFromNormalsOfMesh(const ControlMesh& cage, int levels) {
  const ShadedMesh shaded(cage, 1);
  Points3d positions, normals;
  shaded.Evaluate(cage.vertices(), &positions, &normals);
  LimitMesh fine = BuildLimitMesh(cage.topology(), cage.tags(), levels);
  TriangleMesh mesh;
  ApplyStencils(fine.position, cage.vertices(), &mesh.vertices);
  mesh.triangles = std::move(fine.triangles);
  const Points3d of_mesh = VertexNormals(mesh);
  double worst = 0;
  for (Eigen::Index k = 0; k < normals.cols(); ++k) {
    const int32_t v = shaded.limit_vertices()[k];
    worst = std::max(worst, (normals.col(k) - of_mesh.col(v)).norm());
  }
  return worst;
}

TEST(ShadedMeshTest, NormalsAreThoseThatFinerAndFinerMeshesTendTo) {
  TriangleMesh bent = testing::Icosphere(1);
  bent.vertices.row(2) += 0.4 * bent.vertices.row(0).cwiseProduct(bent.vertices.row(0));
  for (const ControlMesh& cage : {Cage(bent), Cage(testing::Bipyramid(9))}) {
    const double coarse = DistanceFromNormalsOfMesh(cage, 3);
    const double fine = DistanceFromNormalsOfMesh(cage, 5);
    EXPECT_LT(fine, 0.5 * coarse);
    EXPECT_LT(fine, 0.03);
  }
}

TEST(ShadedMeshTest, EveryFaceOfASharpCubeHasItsNormal) {
  constexpr int kCells = 3;
  const ControlMesh cube = SharpCube(kCells);
  for (const int levels : {0, 1, 2}) {
    const ShadedMesh shaded(cube, levels);
    const int side = kCells * (1 << levels) + 1;
    EXPECT_EQ(shaded.limit_vertices().size(), 6u * side * side);
    Points3d positions, normals;
    shaded.Evaluate(cube.vertices(), &positions, &normals);
    for (Eigen::Index k = 0; k < normals.cols(); ++k) {
      EXPECT_NEAR(normals.col(k).norm(), 1, 1e-12);
      int axis = 0;
      EXPECT_NEAR(normals.col(k).cwiseAbs().maxCoeff(&axis), 1, 1e-12);
      EXPECT_NEAR(positions(axis, k), normals(axis, k) > 0 ? 1 : 0, 1e-12);
    }
  }
}

TEST(ShadedMeshTest, ABoundaryDoublesNothing) {
  const ControlMesh tube = Cage(testing::Tube(8, 4));
  const ShadedMesh shaded(tube, 1);
  const std::set<int32_t> once(shaded.limit_vertices().begin(), shaded.limit_vertices().end());
  EXPECT_EQ(once.size(), shaded.limit_vertices().size());
  Points3d positions, normals;
  shaded.Evaluate(tube.vertices(), &positions, &normals);
  for (Eigen::Index k = 0; k < normals.cols(); ++k) {  // outward, without a part along z
    EXPECT_NEAR(normals(2, k), 0, 1e-6);
    EXPECT_GT(normals.col(k).dot(positions.col(k).cwiseProduct(Eigen::Vector3d(1, 1, 0))), 0.5);
  }
}

TEST(ShadedMeshTest, TheTipOfAConeLooksAlongItsAxis) {
  const ControlMesh cage = Cage(testing::Bipyramid(9), {{}, {0}});  // the same in three directions
  const ShadedMesh shaded(cage, 2);
  Points3d positions, normals;
  shaded.Evaluate(cage.vertices(), &positions, &normals);
  int tips = 0;
  for (Eigen::Index k = 0; k < normals.cols(); ++k) {
    if (shaded.limit_vertices()[k] != 0) continue;
    ++tips;
    EXPECT_LT((positions.col(k) - cage.vertices().col(0)).norm(), 1e-12);
    EXPECT_NEAR(normals(2, k), 1, 1e-9);
  }
  EXPECT_EQ(tips, 1);
}

}  // namespace
}  // namespace cagefit
