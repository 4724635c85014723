#include "core/mesh/control_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using ::testing::HasSubstr;

std::string ErrorOf(const TriangleMesh& mesh, const CreaseTags& tags = {}) {
  const auto control = ControlMesh::Create(mesh.vertices, mesh.triangles, tags);
  if (control.ok()) return "accepted";
  EXPECT_EQ(control.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(control.status().message());
}

TEST(ControlMeshTest, KeepsWhatItWasGiven) {
  const TriangleMesh grid = testing::OpenGrid(2);
  const auto control = ControlMesh::Create(grid.vertices, grid.triangles, {{{4, 8}}, {4}});
  ASSERT_TRUE(control.ok()) << control.status();
  EXPECT_EQ(control->vertices(), grid.vertices);
  EXPECT_EQ(control->triangles(), grid.triangles);
  EXPECT_EQ(control->tags().edges.size(), 1u);
  EXPECT_EQ(control->tags().corners, std::vector<int32_t>{4});
}

TEST(ControlMeshTest, MovedVerticesShareTheTopology) {
  const TriangleMesh grid = testing::OpenGrid(2);
  const ControlMesh control = *ControlMesh::Create(grid.vertices, grid.triangles);
  const ControlMesh moved = control.WithVertices(2 * grid.vertices);
  EXPECT_EQ(&moved.topology(), &control.topology());
  EXPECT_EQ(moved.vertices(), 2 * grid.vertices);
  EXPECT_EQ(control.vertices(), grid.vertices);
}

TEST(ControlMeshErrorTest, NamesAVertexThatIsNotFinite) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    TriangleMesh grid = testing::OpenGrid(2);
    grid.vertices(1, 5) = bad;
    EXPECT_THAT(ErrorOf(grid), HasSubstr("vertex 5"));
  }
}

TEST(ControlMeshErrorTest, NamesATriangleWithoutArea) {
  TriangleMesh grid = testing::OpenGrid(2);
  grid.vertices.col(0) = grid.vertices.col(1);
  EXPECT_THAT(ErrorOf(grid), HasSubstr("triangle 0 (0, 1, 4): its area is 0"));
}

TEST(ControlMeshErrorTest, NamesAnInteriorVertexOfValenceTwo) {
  // One triangle and its back: the only way for a closed fan to have two triangles.
  TriangleMesh pillow = {testing::OpenGrid(1).vertices.leftCols(3), Triangles(3, 2)};
  pillow.triangles << 0, 0,  //
      1, 2,                  //
      2, 1;
  EXPECT_THAT(ErrorOf(pillow), HasSubstr("vertex 0: interior valence 2"));
}

TEST(ControlMeshErrorTest, PassesOnWhatTopologyFinds) {
  TriangleMesh grid = testing::OpenGrid(2);
  grid.triangles(0, 3) = 99;
  EXPECT_THAT(ErrorOf(grid), HasSubstr("vertex index 99"));
}

TEST(ControlMeshErrorTest, NamesACreaseThatIsNoEdge) {
  EXPECT_THAT(ErrorOf(testing::OpenGrid(2), {{{0, 8}}, {}}), HasSubstr("crease edge (0, 8)"));
  EXPECT_THAT(ErrorOf(testing::OpenGrid(2), {{{0, 900}}, {}}), HasSubstr("crease edge (0, 900)"));
}

TEST(ControlMeshErrorTest, NamesACornerOutOfRange) {
  EXPECT_THAT(ErrorOf(testing::OpenGrid(2), {{}, {9}}), HasSubstr("corner 9"));
  EXPECT_THAT(ErrorOf(testing::OpenGrid(2), {{}, {-1}}), HasSubstr("corner -1"));
}

}  // namespace
}  // namespace cagefit
