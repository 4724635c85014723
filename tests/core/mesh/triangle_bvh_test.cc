#include "core/mesh/triangle_bvh.h"

#include <gtest/gtest.h>

#include <random>

#include "core/mesh/triangle_mesh.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

class Random {
 public:
  explicit Random(uint32_t seed) : engine_(seed) {}
  Eigen::Vector3d InBox(double half_size) {
    std::uniform_real_distribution<double> coordinate(-half_size, half_size);
    return {coordinate(engine_), coordinate(engine_), coordinate(engine_)};
  }

 private:
  std::mt19937 engine_;
};

// p is the closest point of a convex set to x exactly if no point y of the set has (x - p).(y - p)
// > 0; for a triangle its corners decide.
void ExpectClosest(const Eigen::Vector3d& x, const Eigen::Matrix3d& corners,
                   const ClosestPoint& found, double tolerance) {
  for (int c = 0; c < 3; ++c) {
    EXPECT_LE((x - found.point).dot(corners.col(c) - found.point), tolerance);
  }
  const Eigen::Vector3d point = (1 - found.u - found.v) * corners.col(0) +
                                found.u * corners.col(1) + found.v * corners.col(2);
  EXPECT_LT((point - found.point).norm(), tolerance);
  EXPECT_NEAR(found.distance, (x - point).norm(), tolerance);
  EXPECT_GE(found.u, 0);
  EXPECT_GE(found.v, 0);
  EXPECT_LE(found.u + found.v, 1 + 1e-15);
}

ClosestPoint BruteForce(const Eigen::Vector3d& x, const TriangleMesh& mesh) {
  ClosestPoint best;
  double squared = std::numeric_limits<double>::infinity();
  for (int32_t f = 0; f < mesh.triangles.cols(); ++f) {
    ClosestPoint candidate = ClosestPointOnTriangle(x, mesh.vertices.col(mesh.triangles(0, f)),
                                                    mesh.vertices.col(mesh.triangles(1, f)),
                                                    mesh.vertices.col(mesh.triangles(2, f)));
    if ((x - candidate.point).squaredNorm() < squared) {
      squared = (x - candidate.point).squaredNorm();
      best = candidate;
      best.triangle = f;
    }
  }
  return best;
}

TEST(ClosestPointOnTriangleTest, IsOptimalForRandomTriangles) {
  Random random(1);
  for (int trial = 0; trial < 2000; ++trial) {
    Eigen::Matrix3d corners;
    for (int c = 0; c < 3; ++c) corners.col(c) = random.InBox(1);
    const Eigen::Vector3d x = random.InBox(2);
    ExpectClosest(x, corners,
                  ClosestPointOnTriangle(x, corners.col(0), corners.col(1), corners.col(2)), 1e-12);
  }
}

TEST(ClosestPointOnTriangleTest, TakesTrianglesWithoutAreaAsSegmentsOrPoints) {
  Random random(2);
  for (int trial = 0; trial < 500; ++trial) {
    const Eigen::Vector3d p = random.InBox(1), q = random.InBox(1), x = random.InBox(2);
    Eigen::Matrix3d cases[5];
    cases[0] << p, q, 0.3 * p + 0.7 * q;
    cases[1] << p, 0.3 * p + 0.7 * q, q;
    cases[2] << p, p, q;
    cases[3] << p, q, q;
    cases[4] << p, p, p;
    for (const Eigen::Matrix3d& corners : cases) {
      ExpectClosest(x, corners,
                    ClosestPointOnTriangle(x, corners.col(0), corners.col(1), corners.col(2)),
                    1e-7);
    }
  }
}

TEST(ClosestPointOnTriangleTest, StaysAccurateOnNeedles) {
  Random random(5);
  for (const double width : {1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12, 1e-15}) {
    for (int trial = 0; trial < 300; ++trial) {
      const Eigen::Vector3d p = random.InBox(1), q = random.InBox(1), x = random.InBox(2);
      Eigen::Matrix3d corners;
      corners << p, q, 0.4 * p + 0.6 * q + random.InBox(width);
      ExpectClosest(x, corners,
                    ClosestPointOnTriangle(x, corners.col(0), corners.col(1), corners.col(2)),
                    1e-7);
    }
  }
}

TEST(TriangleBvhTest, AgreesWithBruteForce) {
  Random random(3);
  for (const TriangleMesh& mesh :
       {testing::Icosphere(2), testing::OpenGrid(9), testing::Torus(20, 9), testing::Tube(12, 7),
        testing::MixedValences(), testing::OpenGrid(1)}) {
    const TriangleBvh bvh(mesh.vertices, mesh.triangles);
    for (int trial = 0; trial < 300; ++trial) {
      const Eigen::Vector3d x = random.InBox(trial % 2 == 0 ? 1.2 : 5);
      const ClosestPoint found = bvh.Closest(x), expected = BruteForce(x, mesh);
      EXPECT_EQ(found.triangle, expected.triangle);
      EXPECT_EQ(found.distance, expected.distance);
      EXPECT_EQ(found.point, expected.point);
    }
  }
}

TEST(TriangleBvhTest, GivesTheLowestOfEquallyNearTriangles) {
  // Every triangle twice, and queries above grid vertices, where up to six meet.
  const TriangleMesh grid = testing::OpenGrid(8);
  Triangles twice(3, 2 * grid.triangles.cols());
  twice << grid.triangles, grid.triangles;
  const TriangleMesh doubled = {grid.vertices, twice};
  const TriangleBvh bvh(doubled.vertices, doubled.triangles);
  for (Eigen::Index v = 0; v < grid.vertices.cols(); ++v) {
    for (const double height : {0.0, 0.5, 1.0}) {
      const Eigen::Vector3d x = grid.vertices.col(v) + Eigen::Vector3d(0, 0, height);
      EXPECT_EQ(bvh.Closest(x).triangle, BruteForce(x, doubled).triangle);
    }
  }
}

TEST(TriangleBvhTest, FindsNothingAtOrBeyondTheSearchRadius) {
  const TriangleMesh grid = testing::OpenGrid(4);
  const TriangleBvh bvh(grid.vertices, grid.triangles);
  const Eigen::Vector3d x(0.4, 0.3, 2);
  EXPECT_EQ(bvh.Closest(x, 2).triangle, -1);
  EXPECT_EQ(bvh.Closest(x, 2).distance, std::numeric_limits<double>::infinity());
  EXPECT_EQ(bvh.Closest(x, 2.0001).distance, 2);
}

TEST(TriangleBvhTest, OfNothingFindsNothing) {
  const TriangleBvh bvh;
  EXPECT_TRUE(bvh.empty());
  EXPECT_EQ(bvh.Closest({0, 0, 0}).triangle, -1);
}

TEST(TriangleBvhTest, BuildReplacesTheContent) {
  const TriangleMesh grid = testing::OpenGrid(6), sphere = testing::Icosphere(0);
  TriangleBvh bvh(grid.vertices, grid.triangles);
  bvh.Build(sphere.vertices, sphere.triangles);
  EXPECT_EQ(bvh.Closest({0, 0, 3}).distance, BruteForce({0, 0, 3}, sphere).distance);
}

TEST(TriangleBvhTest, StaysExactFarFromTheOrigin) {
  // Boxes are floats, whose spacing out there exceeds a cell of the grid.
  TriangleMesh grid = testing::OpenGrid(10);
  const Eigen::Vector3d far(1e7 / 3, -2e7 / 3, 1e7 / 7);
  grid.vertices.colwise() += far;
  const TriangleBvh bvh(grid.vertices, grid.triangles);
  Random random(4);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d x = far + random.InBox(1.5);
    EXPECT_EQ(bvh.Closest(x).distance, BruteForce(x, grid).distance);
  }
}

TEST(TriangleBvhTest, TakesManyTrianglesInOnePlace) {
  const TriangleMesh one = {testing::OpenGrid(1).vertices,
                            testing::OpenGrid(1).triangles.col(0).replicate(1, 5000)};
  const TriangleBvh bvh(one.vertices, one.triangles);
  EXPECT_EQ(bvh.Closest({0.5, 0.5, 1}).triangle, 0);
}

}  // namespace
}  // namespace cagefit
