#include "core/image/mesh_renderer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "core/image/views.h"
#include "tests/core/image/scenes.h"

namespace cagefit {
namespace {

using testing::Icosphere;
using testing::TestCamera;
using testing::TriangleSoup;
using testing::WideCamera;

double Area(const Image& silhouette) {
  double sum = 0;
  for (const float v : silhouette.values) sum += v;
  return sum;
}

TEST(MeshRendererTest, ASphereHasTheSameOutlineAtAnyTessellation) {
  const Camera camera = LookAt({0, 0, 3}, {0, 0, 0}, {0, 1, 0}, M_PI / 3, 256);
  const double radius = camera.fx * std::tan(std::asin(1.0 / 3));
  const Image coarse = RenderMesh(Icosphere(4), camera).silhouette;
  const Image fine = RenderMesh(Icosphere(6), camera).silhouette;
  EXPECT_NEAR(Area(fine), M_PI * radius * radius, 0.2 * radius);
  EXPECT_NEAR(Area(coarse), Area(fine), 0.4 * radius);  // 0.06 pixels of radius
  // PyTorch3D's image is dilated, the more the finer the mesh.
  const SilhouetteOptions soft{SilhouetteMode::kPytorch3d, {}};
  const double grown = Area(RenderMesh(Icosphere(4), camera, soft).silhouette);
  EXPECT_GT(grown, Area(fine) + 2 * M_PI * radius * 0.5);
  EXPECT_GT(Area(RenderMesh(Icosphere(6), camera, soft).silhouette),
            grown + 2 * M_PI * radius * 0.5);
}

TEST(MeshRendererTest, DepthAndNormalsOfASphere) {
  const Eigen::Vector3d eye(0, 0, 3);
  const Camera camera = LookAt(eye, {0, 0, 0}, {0, 1, 0}, M_PI / 3, 128);
  const Rendering image = RenderMesh(Icosphere(5), camera);
  int covered = 0;
  for (int y = 0; y < 128; ++y) {
    for (int x = 0; x < 128; ++x) {
      const Eigen::Vector3d ray =
          camera.R.transpose() *
          Eigen::Vector3d((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      // |eye + z ray| = 1
      const double a = ray.squaredNorm(), b = eye.dot(ray), c = eye.squaredNorm() - 1;
      const double discriminant = b * b - a * c;
      if (discriminant < 0.02) {
        if (discriminant < -0.02) {
          EXPECT_EQ(*image.depth.at(x, y), 0);
        }
        continue;
      }
      ++covered;
      const double z = (-b - std::sqrt(discriminant)) / a;
      EXPECT_NEAR(*image.depth.at(x, y), z, 3e-3);
      const Eigen::Vector3d normal = eye + z * ray;
      const float* n = image.normals.at(x, y);
      EXPECT_GT(normal.dot(Eigen::Vector3d(n[0], n[1], n[2])), 0.998);
    }
  }
  EXPECT_GT(covered, 2000);
}

TEST(MeshRendererTest, OutlineImageIsTheSameForAnyNumberOfThreads) {
  const TriangleMesh mesh = TriangleSoup(500, 0.2, 7);
  const auto run = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const MeshEdges edges(mesh.triangles);
    MeshView view;
    view.Render(mesh.vertices, mesh.triangles, edges, WideCamera(), {});
    Points3d gradient = Points3d::Zero(3, mesh.vertices.cols());
    view.AddGradient(view.silhouette(), &gradient);
    return std::pair(view.silhouette().values, gradient);
  };
  const auto one = run(1), two = run(2);
  EXPECT_EQ(one.first, two.first);
  EXPECT_EQ(one.second, two.second);
}

TEST(MeshRendererTest, ACameraInsideAnObjectIsNoHarm) {
  TriangleMesh mesh = Icosphere(3);
  mesh.vertices *= 1e3;
  for (const float v : RenderMesh(mesh, TestCamera(64)).silhouette.values) {
    EXPECT_TRUE(std::isfinite(v));
  }
  mesh.vertices.row(2).array() += 1e6;
  EXPECT_EQ(Area(RenderMesh(mesh, TestCamera(64)).silhouette), 0);
}

TEST(MeshRendererTest, HandlesAllSizesOfImages) {
  for (const int size : {1, 7, 64, 301}) {
    Camera camera = Resized(WideCamera(), size);
    const Rendering image = RenderMesh(Icosphere(2), camera);
    EXPECT_EQ(image.silhouette.width, camera.width);
    EXPECT_EQ(*image.silhouette.at(camera.width / 2, camera.height / 2), 1);
  }
}

TEST(ViewsTest, SphereViewsSeeTheWholeBallFromAllSides) {
  const Eigen::Vector3d center(1, 2, 3);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Camera& camera : SphereViews(20, center, 2, 128)) {
    ASSERT_TRUE(camera.Validate().ok());
    TriangleMesh ball = Icosphere(3, 2);
    ball.vertices.colwise() += center;
    const Image image = RenderMesh(ball, camera).silhouette;
    for (int k = 0; k < 128; ++k) EXPECT_EQ(*image.at(k, 0) + *image.at(0, k), 0);
    EXPECT_EQ(*image.at(64, 64), 1);
    sum += (camera.center() - center).normalized();
  }
  EXPECT_LT(sum.norm(), 1);
}

TEST(ViewsTest, TutorialViewsAreThoseOfTheirFormula) {
  const std::vector<Camera> views = TutorialViews(20, {0, 0, 0}, 2, 256);
  ASSERT_EQ(views.size(), 20);
  EXPECT_TRUE(views[0].center().isApprox(Eigen::Vector3d(0, 0, -2.7), 1e-12));
  const double e = 360 * 3 / 19.0 * M_PI / 180, a = e - M_PI;
  EXPECT_TRUE(views[3].center().isApprox(
      2.7 * Eigen::Vector3d(std::cos(e) * std::sin(a), std::sin(e), std::cos(e) * std::cos(a)),
      1e-12));
  for (const Camera& camera : views) EXPECT_TRUE(camera.Validate().ok());
}

}  // namespace
}  // namespace cagefit
