#include "core/image/soft_silhouette.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

#include "tests/core/image/naive_silhouette.h"
#include "tests/core/image/scenes.h"

namespace cagefit {
namespace {

using testing::Icosphere;
using testing::NaivePixel;
using testing::NaiveSilhouette;
using testing::TestCamera;
using testing::TriangleSoup;
using testing::WideCamera;

Image Render(const TriangleMesh& mesh, const Camera& camera,
             const SoftSilhouetteOptions& options = {}) {
  ProjectedMesh projected;
  ProjectMesh(mesh.vertices, camera, &projected);
  SoftSilhouette silhouette;
  Image out;
  silhouette.Render(projected, mesh.triangles, camera.width, camera.height, options, &out);
  return out;
}

// Compares with the formula in double precision. Where a decision (inside, blur, nearest) hangs on
// the last digits of single precision the pixel is counted instead.
void ExpectFormula(const TriangleMesh& mesh, const Camera& camera,
                   const SoftSilhouetteOptions& options) {
  const Image image = Render(mesh, camera, options);
  int other = 0, partial = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const NaivePixel naive = NaiveSilhouette(mesh, camera, options, x, y);
      const double error = std::abs(*image.at(x, y) - naive.value);
      if (naive.value > 0.01 && naive.value < 0.99) ++partial;
      if (error <= 1e-5) continue;
      ++other;
      EXPECT_LT(naive.margin, 1e-5)
          << x << " " << y << ": " << *image.at(x, y) << " is not " << naive.value;
      // One triangle for another makes a difference where few count.
      if (options.faces_per_pixel >= 100) {
        EXPECT_LT(error, 1e-4) << x << " " << y;
      }
    }
  }
  EXPECT_LT(other, 1e-3 * static_cast<double>(image.pixel_count()));
  EXPECT_GT(partial, 50);
}

TEST(SoftSilhouetteTest, IsTheFormulaForASphere) {
  for (const int levels : {0, 2, 3}) ExpectFormula(Icosphere(levels), TestCamera(64), {});
}

TEST(SoftSilhouetteTest, IsTheFormulaForTriangleSoups) {
  for (const uint64_t seed : {1, 2, 3}) {
    ExpectFormula(TriangleSoup(60, 0.5, seed), TestCamera(64), {});
    ExpectFormula(TriangleSoup(400, 0.05, seed), WideCamera(), {});
  }
}

TEST(SoftSilhouetteTest, IsTheFormulaWhereMoreTrianglesMeetThanCount) {
  SoftSilhouetteOptions options;
  options.faces_per_pixel = 5;
  ExpectFormula(TriangleSoup(400, 0.3, 4), TestCamera(64), options);
  ExpectFormula(Icosphere(4), TestCamera(64), options);
}

TEST(SoftSilhouetteTest, IsTheFormulaAtOtherSettings) {
  SoftSilhouetteOptions options;
  options.sigma = 1e-3;
  options.blur_radius = 5e-3;
  ExpectFormula(Icosphere(2), WideCamera(), options);
  options.sigma = 1e-5;
  options.blur_radius = 0;
  ExpectFormula(Icosphere(2), TestCamera(128), options);
}

TEST(SoftSilhouetteTest, ImageAndGradientAreTheSameForAnyNumberOfThreads) {
  const TriangleMesh mesh = TriangleSoup(500, 0.2, 7);
  const Camera camera = TestCamera(128);
  const auto run = [&](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    ProjectedMesh projected;
    ProjectMesh(mesh.vertices, camera, &projected);
    SoftSilhouette silhouette;
    Image image;
    silhouette.Render(projected, mesh.triangles, 128, 128, {}, &image);
    Points2d gradient = Points2d::Zero(2, mesh.vertices.cols());
    silhouette.AddGradient(mesh.triangles, image, &gradient);
    return std::pair(image.values, gradient);
  };
  const auto one = run(1), two = run(2);
  EXPECT_EQ(one.first, two.first);
  EXPECT_EQ(one.second, two.second);
}

TEST(SoftSilhouetteTest, AnEmptySceneIsEmpty) {
  TriangleMesh mesh = Icosphere(1);
  mesh.vertices.row(2).array() += 50;  // behind the camera
  const Image image = Render(mesh, TestCamera(64));
  EXPECT_EQ(*std::max_element(image.values.begin(), image.values.end()), 0);
}

TEST(SoftSilhouetteTest, DegenerateAndHugeTrianglesDoNoHarm) {
  TriangleMesh mesh = Icosphere(1);
  const int64_t n = mesh.triangles.cols();
  mesh.triangles.conservativeResize(3, n + 2);
  mesh.triangles.col(n) << 0, 0, 5;
  mesh.triangles.col(n + 1) << 3, 3, 3;
  const Image with = Render(mesh, TestCamera(64));
  EXPECT_EQ(with.values, Render(Icosphere(1), TestCamera(64)).values);
  mesh.vertices *= 1e3;  // the camera is inside
  for (const float v : Render(mesh, TestCamera(64)).values) EXPECT_TRUE(std::isfinite(v));
}

}  // namespace
}  // namespace cagefit
