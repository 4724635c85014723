// Fits by images alone.
#include <gtest/gtest.h>

#include <cmath>

#include "core/fit/fitter.h"
#include "core/image/views.h"
#include "core/subdiv/limit.h"
#include "tests/core/cloud/sphere_cloud.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using testing::Icosphere;

constexpr double kRadius = 2;

// A sphere's control mesh that is too small and a little beside it.
ControlMesh SmallSphere() {
  TriangleMesh mesh = Icosphere(3, 0.93 * kRadius);
  mesh.vertices.row(0).array() += 0.03 * kRadius;
  return *ControlMesh::Create(mesh.vertices, mesh.triangles, {});
}

FitOptions ImagesAlone(Views views) {
  FitOptions options;
  options.distance.weight = 0;
  options.coverage.weight = 0;
  options.arap.weight = 1e-4;
  options.image.views = views;
  options.solver.relative_decrease = 1e-3;
  return options;
}

// Mean distance of the fitted surface from the sphere, outwards, in pixels of the views.
double RadiusError(const FitOptions& options, const FrameSource& images, const Camera& camera,
                   double most = 1.5) {
  const ControlMesh cage = SmallSphere();
  PointCloud cloud = testing::SphereCloud(100'000);
  cloud.points *= static_cast<float>(kRadius);
  Fitter fitter =
      *Fitter::Create(cage, *Normalization::FromBox(BoundingBox(cloud.points)), options);
  Points3d fitted;
  // As an earlier fit the points may move it, but not change its size: that is left to the images.
  const auto summary = fitter.Fit(cloud, {cage.vertices()}, nullptr, nullptr, &fitted,
                                  StartKind::kEarlierFit, images);
  EXPECT_TRUE(summary.ok()) << summary.status();
  EXPECT_GT(summary->images, 0);
  EXPECT_GT(summary->initial.image, 10 * summary->final.image);
  Points3d Q;
  ApplyStencils(BuildLimitMesh(cage.topology(), cage.tags(), 2).position, fitted, &Q);
  const Eigen::RowVectorXd errors = Q.colwise().norm().array() - kRadius;
  const double pixels = camera.fx / camera.center().norm();
  EXPECT_LT(errors.cwiseAbs().maxCoeff() * pixels, most);
  return errors.mean() * pixels;
}

std::vector<Camera> Cameras() { return SphereViews(20, {0, 0, 0}, std::sqrt(3) * kRadius, 256); }

TEST(ImageFitTest, ASphereByTheImagesOfAFinerMesh) {
  const TriangleMesh fine = Icosphere(6, kRadius);
  FrameSource images;
  images.mesh = &fine;
  EXPECT_NEAR(RadiusError(ImagesAlone(Views::kSphere), images, Cameras()[0]), 0, 0.1);
}

TEST(ImageFitTest, ASphereByTheImagesOfACloud) {
  EXPECT_NEAR(RadiusError(ImagesAlone(Views::kSphere), {}, Cameras()[0]), 0, 0.1);
}

TEST(ImageFitTest, ASphereByHardMasks) {
  const std::vector<Camera> cameras = Cameras();
  std::vector<Image> masks;
  for (const Camera& camera : cameras) {
    const double distance = camera.center().norm();
    const double radius = camera.fx * std::tan(std::asin(kRadius / distance));
    Image mask(camera.width, camera.height);
    for (int y = 0; y < mask.height; ++y) {
      for (int x = 0; x < mask.width; ++x) {
        *mask.at(x, y) = std::hypot(x - camera.cx, y - camera.cy) < radius ? 1 : 0;
      }
    }
    masks.push_back(std::move(mask));
  }
  masks[3] = Image();  // a view that is missing
  FrameSource images;
  images.cameras = &cameras;
  images.masks = &masks;
  EXPECT_NEAR(RadiusError(ImagesAlone(Views::kCameras), images, cameras[0]), 0, 0.1);
}

// An earlier fit that lies where no image reaches is moved onto the points first.
TEST(ImageFitTest, ImagesAloneBeginWhereTheBodyHasMovedTo) {
  const ControlMesh cage = SmallSphere();
  PointCloud cloud = testing::SphereCloud(20'000);
  cloud.points *= static_cast<float>(kRadius);
  Fitter fitter = *Fitter::Create(cage, *Normalization::FromBox(BoundingBox(cloud.points)),
                                  ImagesAlone(Views::kSphere));
  cloud.points.row(1).array() += static_cast<float>(1.5 * kRadius);
  Points3d fitted;
  const auto summary =
      fitter.Fit(cloud, {cage.vertices()}, nullptr, nullptr, &fitted, StartKind::kEarlierFit);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_LT(summary->initial.distance, 1e-12);
  EXPECT_NEAR(fitted.row(1).mean(), 1.5 * kRadius, 0.05 * kRadius);
}

TEST(ImageFitTest, SolversThatDoNotTakeImagesAreRefused) {
  FitOptions options = ImagesAlone(Views::kSphere);
  EXPECT_TRUE(options.Validate().ok());
  options.solver.solver = Solver::kCeres;
  EXPECT_EQ(options.Validate().message(),
            "solver is CERES, which does not take images; use GAUSS_NEWTON or ADAM");
  options.solver.solver = Solver::kGaussNewton;
  options.image.mode = SilhouetteMode::kPytorch3d;
  EXPECT_EQ(options.Validate().message(),
            "image.mode is PYTORCH3D, which has no Gauss-Newton rows; use solver ADAM");
  options.solver.solver = Solver::kAdam;
  EXPECT_TRUE(options.Validate().ok());
}

TEST(ImageFitTest, AdamFitsBySomeViewsAtATime) {
  const TriangleMesh fine = Icosphere(5, kRadius);
  FrameSource images;
  images.mesh = &fine;
  FitOptions options = ImagesAlone(Views::kSphere);
  options.solver.solver = Solver::kAdam;
  options.solver.max_iterations = 300;
  options.solver.learning_rate = 2e-3;
  options.image.view_count = 20;
  options.image.views_per_iteration = 2;
  options.image.size = 128;
  EXPECT_NEAR(RadiusError(options, images, Cameras()[0], /*most=*/2), 0, 0.3);
  options.image.mode = SilhouetteMode::kPytorch3d;
  options.solver.max_iterations = 100;
  options.image.size = 64;
  EXPECT_NEAR(RadiusError(options, images, Cameras()[0], /*most=*/3), 0, 1);
}

}  // namespace
}  // namespace cagefit
