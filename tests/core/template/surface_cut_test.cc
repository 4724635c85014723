#include "core/template/surface_cut.h"

#include <gtest/gtest.h>

#include "core/mesh/topology.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

TEST(SurfaceCutTest, TheRimFollowsTheLevelLine) {
  const TriangleMesh grid = testing::OpenGrid(20);
  const Eigen::ArrayXd value = (grid.vertices.topRows<2>().colwise() - Eigen::Vector2d(0.5, 0.5))
                                   .colwise()
                                   .norm()
                                   .transpose();
  const TriangleMesh disk = CutBelow(grid, value, 0.33);
  const auto topology =
      Topology::Create(static_cast<int32_t>(disk.vertices.cols()), disk.triangles);
  ASSERT_TRUE(topology.ok()) << topology.status();
  const std::vector<std::vector<int32_t>> loops = topology->BoundaryLoops();
  ASSERT_EQ(loops.size(), 1u);
  for (const int32_t v : loops[0]) {
    EXPECT_NEAR((disk.vertices.col(v) - Eigen::Vector3d(0.5, 0.5, 0)).norm(), 0.33, 6e-3);
  }
}

TEST(SurfaceCutTest, AllOrNothing) {
  const TriangleMesh grid = testing::OpenGrid(3);
  const Eigen::ArrayXd value = Eigen::ArrayXd::Zero(grid.vertices.cols());
  EXPECT_EQ(CutBelow(grid, value, 1).triangles.cols(), grid.triangles.cols());
  EXPECT_EQ(CutBelow(grid, value, 0).triangles.cols(), 0);
}

}  // namespace
}  // namespace cagefit
