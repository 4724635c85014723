#include "core/image/mesh_outline.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/image/mesh_renderer.h"
#include "tests/core/image/scenes.h"

namespace cagefit {
namespace {

using testing::Icosphere;
using testing::TestCamera;
using testing::Together;
using testing::Torus;
using testing::TriangleSoup;
using testing::WideCamera;

struct Scene {
  Scene(const TriangleMesh& mesh, const Camera& camera) : mesh(mesh), edges(mesh.triangles) {
    ProjectMesh(mesh.vertices, camera, &projected);
    tiles.Build(projected, mesh.triangles, camera.width, camera.height, 0, kReach + 1);
    outline.Find(projected, mesh.triangles, edges, tiles, camera.width, camera.height, kReach);
  }

  bool IsCovered(const Eigen::Vector2d& p) const {
    for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
      const auto corner = [&](int k) -> Eigen::Vector2d {
        return projected.points.col(mesh.triangles(k, f)).head<2>() - p;
      };
      const Eigen::Vector2d a = corner(0), b = corner(1), c = corner(2);
      const double ab = a[0] * b[1] - a[1] * b[0], bc = b[0] * c[1] - b[1] * c[0],
                   ca = c[0] * a[1] - c[1] * a[0];
      if ((ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0)) return true;
    }
    return false;
  }

  // The outline's point nearest to p.
  Eigen::Vector2d Nearest(const Eigen::Vector2d& p) const {
    Eigen::Vector2d nearest = Eigen::Vector2d::Constant(1e9);
    for (int64_t k = 0; k < outline.outline().segments.cols(); ++k) {
      const Eigen::Vector2d a = outline.outline().points.col(2 * k),
                            along = outline.outline().points.col(2 * k + 1) - a;
      const double t = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
      const Eigen::Vector2d c = a + t * along;
      if ((c - p).norm() < (nearest - p).norm()) nearest = c;
    }
    return nearest;
  }

  static constexpr int kReach = 4;
  TriangleMesh mesh;
  MeshEdges edges;
  ProjectedMesh projected;
  TriangleTiles tiles;
  MeshOutline outline;
};

// Within the distance to the outline all is as covered as the pixel is; around the nearest point of
// the outline some is covered and some is not.
void ExpectTrueDistances(const Scene& scene, const Camera& camera, int tries) {
  Random random(9);
  int checked = 0;
  for (int k = 0; k < 50 * tries && checked < tries; ++k) {
    const Eigen::Vector2d p(random.Uniform(0, camera.width - 1),
                            random.Uniform(0, camera.height - 1));
    const Eigen::Vector2d c = scene.Nearest(p);
    const double d = (c - p).norm();
    if (d > Scene::kReach || d < 1e-3) continue;
    ++checked;
    const bool inside = scene.IsCovered(p);
    constexpr int kDirections = 360;
    int covered = 0;
    for (int a = 0; a < kDirections; ++a) {
      const double angle = 2 * M_PI * (a + 0.5) / kDirections;
      const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
      ASSERT_EQ(scene.IsCovered(p + random.Uniform(0, 0.9999) * d * direction), inside)
          << p.transpose() << " at distance " << d;
      covered += scene.IsCovered(c + 1e-5 * direction);
    }
    EXPECT_GT(covered, 0) << p.transpose() << " at distance " << d;
    EXPECT_LT(covered, kDirections) << p.transpose() << " at distance " << d;
  }
  EXPECT_EQ(checked, tries);
}

TEST(MeshOutlineTest, IsTheBoundaryOfWhatIsCovered) {
  ExpectTrueDistances(Scene(Icosphere(2), TestCamera(64)), TestCamera(64), 100);
  ExpectTrueDistances(Scene(Torus(24, 12), WideCamera()), WideCamera(), 100);
}

TEST(MeshOutlineTest, IsTheBoundaryOfWhatIsCoveredWhereShapesCross) {
  TriangleMesh other = Torus(24, 12, 0.7, 0.3);
  other.vertices.row(0).array() += 0.5;
  ExpectTrueDistances(Scene(Together(Icosphere(2, 0.8), other), WideCamera()), WideCamera(), 150);
  for (const uint64_t seed : {1, 2, 3}) {
    ExpectTrueDistances(Scene(TriangleSoup(40, 0.6, seed), WideCamera()), WideCamera(), 100);
  }
}

TEST(MeshOutlineTest, OfASphereLiesOnItsCircle) {
  const Camera camera = LookAt({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, M_PI / 3, 256);
  const Scene scene(Icosphere(4), camera);
  // The cone that touches the unit sphere from distance 3.
  const double radius = camera.fx * std::tan(std::asin(1.0 / 3));
  double length = 0;
  for (int64_t k = 0; k < scene.outline.outline().segments.cols(); ++k) {
    const Eigen::Vector2d a = scene.outline.outline().points.col(2 * k),
                          b = scene.outline.outline().points.col(2 * k + 1);
    length += (b - a).norm();
    const double r = (0.5 * (a + b) - Eigen::Vector2d(camera.cx, camera.cy)).norm();
    EXPECT_NEAR(r, radius, 0.002 * radius);
  }
  EXPECT_NEAR(length, 2 * M_PI * radius, 0.01 * radius);
}

TEST(MeshOutlineTest, FoldsThatAreCoveredAreNoPartOfIt) {
  TriangleMesh small = Icosphere(2, 0.5);
  const Scene both(Together(Icosphere(3), small), TestCamera(64));
  const Scene one(Icosphere(3), TestCamera(64));
  EXPECT_EQ(both.outline.pieces().size(), one.outline.pieces().size());
}

TEST(MeshOutlineTest, EdgesAreNumberedAsInTopology) {
  const TriangleMesh mesh = Torus(12, 6);
  const MeshEdges edges(mesh.triangles);
  EXPECT_EQ(edges.size(), 3 * mesh.triangles.cols() / 2);
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const auto& [a, b] = edges.vertices(edges.of_triangle(f, c));
      EXPECT_EQ(std::minmax(mesh.triangles(c, f), mesh.triangles((c + 1) % 3, f)),
                std::minmax(a, b));
    }
  }
}

}  // namespace
}  // namespace cagefit
