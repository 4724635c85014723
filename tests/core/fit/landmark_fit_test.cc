// What landmarks and boundaries do for a fit that points alone leave undecided.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/fit/fitter.h"
#include "core/subdiv/limit_surface.h"
#include "tests/core/fit/fit_fixture.h"

namespace cagefit {
namespace {

Points3d FitTo(const ControlMesh& cage, const PointCloud& target, const FitOptions& options,
               const FrameSource& source, FitSummary* summary = nullptr) {
  auto fitter = Fitter::Create(cage, *Normalization::FromBox(BoundingBox(target.points)), options);
  Points3d fitted;
  const auto result = fitter->Fit(target, {cage.vertices()}, nullptr, nullptr, &fitted,
                                  StartKind::kTemplate, source);
  EXPECT_TRUE(result.ok()) << result.status();
  if (result.ok() && summary != nullptr) *summary = *result;
  return fitted;
}

// A sphere that turned about itself: its points say nothing of that.
TEST(LandmarkFitTest, LandmarksTurnASphere) {
  const double radius = 30;
  const ControlMesh cage = testing::SphereCage(2, radius);
  const PointCloud sphere = testing::EllipsoidCloud(8000, Eigen::Vector3d::Constant(radius));
  const LimitSurface surface(cage.topology(), cage.tags());
  const auto rotation =
      Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  // Where the places are before and have to be.
  std::vector<SurfacePoint> places = {{0, 0, 0}};
  for (int32_t f = 5; f < cage.triangles().cols(); f += 20) places.push_back({f, 0.2, 0.3});
  const Points3d before = FitTo(cage, sphere, {}, {});
  const StencilMatrix S = surface.Stencils(places, Derivatives::kNone)->position;
  Points3d from, to;
  ApplyStencils(S, before, &from);
  std::vector<Landmark> landmarks;
  for (size_t l = 0; l < places.size(); ++l) {
    landmarks.push_back({-1, places[l], rotation * from.col(l)});
  }
  // And one control vertex.
  landmarks.push_back({17, {}, rotation * before.col(17)});
  FrameSource source;
  source.landmarks = &landmarks;
  FitSummary summary;
  const Points3d fitted = FitTo(cage, sphere, {}, source, &summary);
  EXPECT_GT(summary.initial.landmarks, 1);
  ApplyStencils(S, fitted, &to);
  EXPECT_LT((to - rotation * from).colwise().norm().maxCoeff(), 0.01 * radius);
  EXPECT_LT((fitted.col(17) - rotation * before.col(17)).norm(), 0.01 * radius);
  // The rest came along.
  EXPECT_LT((fitted - rotation * before).colwise().norm().mean(), 0.04 * radius);

  FitOptions off;
  off.landmarks.weight = 0;
  EXPECT_EQ(FitTo(cage, sphere, off, source), before);
}

// A disk that is 10 % too small: without its boundary nothing draws it out.
TEST(LandmarkFitTest, TheBoundaryDrawsASurfaceToItsEnd) {
  const TriangleMesh disk = testing::OpenDisk(5, 45);
  const ControlMesh cage = *ControlMesh::Create(disk.vertices, disk.triangles);
  const TriangleMesh target = testing::OpenDisk(60, 50);
  const LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), 2);
  const auto reach_of = [&](double weight, bool by_mesh) {
    FitOptions options;
    options.coverage.weight = 0;
    options.boundary.weight = weight;
    FrameSource source;
    if (by_mesh) source.mesh = &target;
    Points3d surface;
    ApplyStencils(limit.position, FitTo(cage, CloudFromMesh(target), options, source), &surface);
    return surface.colwise().norm().maxCoeff();
  };
  EXPECT_LT(reach_of(0, true), 47);
  EXPECT_NEAR(reach_of(0.1, true), 50, 0.25);
  EXPECT_NEAR(reach_of(0.1, false), 50, 0.75);  // of points: half of their spacing inside
}

TEST(LandmarkFitTest, ABadLandmarkIsNamed) {
  const ControlMesh cage = testing::SphereCage(1, 1);
  const PointCloud cloud = testing::EllipsoidCloud(2000, {1, 1, 1});
  auto fitter = Fitter::Create(cage, *Normalization::FromBox(BoundingBox(cloud.points)), {});
  const std::vector<Landmark> landmarks = {{42, {}, {0, 0, 0}}};
  FrameSource source;
  source.landmarks = &landmarks;
  Points3d fitted;
  const auto result = fitter->Fit(cloud, {cage.vertices()}, nullptr, nullptr, &fitted,
                                  StartKind::kTemplate, source);
  EXPECT_EQ(result.status().message(), "landmarks[0].vertex is 42; the mesh has 42 vertices");
}

}  // namespace
}  // namespace cagefit
