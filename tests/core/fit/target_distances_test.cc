#include "core/fit/target_distances.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "tests/core/fit/fit_fixture.h"

namespace cagefit {
namespace {

TEST(TargetDistancesTest, AreThoseOfALimitSurfaceThatIsKnown) {
  // The limit of a cage whose vertices are equal is not a sphere; that of a plane is the plane.
  const TriangleMesh grid = testing::OpenGrid(6);
  const ControlMesh cage = ControlMesh::Create(grid.vertices, grid.triangles).value();
  Points3f points(3, 3);
  points << 0.5F, 0.25F, 0.6F,  //
      0.5F, 0.7F, 0.3F,         //
      0.125F, -2, 0;
  const TargetDistances d = DistancesToFit(cage, points);
  EXPECT_NEAR(d.distance[0], 0.125, 1e-12);
  EXPECT_NEAR(d.distance[1], 2, 1e-12);
  EXPECT_NEAR(d.distance[2], 0, 1e-7);
}

TEST(TargetDistancesTest, TrianglesAreThoseOfTheControlMesh) {
  for (const int levels : {1, 4}) {  // refined three times, and once
    const ControlMesh cage = testing::SphereCage(levels, 1);
    Points3f centers(3, cage.topology().triangle_count());
    for (int32_t f = 0; f < centers.cols(); ++f) {
      const auto t = cage.triangles().col(f);
      centers.col(f) =
          (cage.vertices().col(t[0]) + cage.vertices().col(t[1]) + cage.vertices().col(t[2]))
              .normalized()
              .cast<float>();
    }
    const TargetDistances d = DistancesToFit(cage, centers);
    for (int32_t f = 0; f < centers.cols(); ++f) EXPECT_EQ(d.triangle[f], f);
  }
}

TEST(TargetDistancesTest, TheExtentLeavesOutOutliersAndTheFarthestOfAThousand) {
  std::vector<double> distances(5000);
  std::iota(distances.begin(), distances.end(), 1);
  std::swap(distances[0], distances[4999]);
  const DistanceExtent all = Extent(distances, 0);
  EXPECT_EQ(all.max, 5000);
  EXPECT_EQ(all.most, 4995);
  EXPECT_NEAR(all.rms, std::sqrt(5001.0 * 10001 / 6), 1e-9);  // sum of squares of 1 to n
  const DistanceExtent without = Extent(distances, 1000);
  EXPECT_EQ(without.max, 4000);
  EXPECT_EQ(without.most, 3996);
  EXPECT_EQ(Extent({1, 2}, 2).max, 0);
  EXPECT_EQ(Extent({1, 2}, 0).most, 2) << "of few points, all count";
}

}  // namespace
}  // namespace cagefit
