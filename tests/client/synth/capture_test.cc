#include "client/synth/capture.h"

#include <gtest/gtest.h>

#include "core/mesh/triangle_bvh.h"

namespace cagefit::client {
namespace {

CaptureOptions Small() {
  CaptureOptions options;
  options.points = 3000;
  return options;
}

// Distances of the cloud's points to the moved mesh.
Eigen::VectorXd Distances(const SynthShape& shape, const PointCloud& cloud, int frame) {
  const TriangleBvh surface(shape.Vertices(FrameTime(frame)), shape.rest().triangles);
  Eigen::VectorXd distances(cloud.size());
  for (int64_t i = 0; i < cloud.size(); ++i) {
    distances[i] = surface.Closest(cloud.points.col(i).cast<double>()).distance;
  }
  return distances;
}

TEST(CaptureTest, PointsLieOnTheMovedSurface) {
  const auto shape = MakeBlob(1);
  const PointCloud cloud = CaptureFrame(*shape, 11, Small());
  EXPECT_EQ(cloud.size(), 3000);
  EXPECT_LT(Distances(*shape, cloud, 11).maxCoeff(), 2e-3);  // of the facets of the mesh
  EXPECT_NEAR(cloud.normals.colwise().norm().minCoeff(), 1, 1e-5);
}

TEST(CaptureTest, EveryFrameHasNewPoints) {
  const auto shape = MakeTube(1);
  const PointCloud a = CaptureFrame(*shape, 0, Small()), b = CaptureFrame(*shape, 1, Small());
  EXPECT_GT((a.points - b.points).colwise().norm().mean(), 0.1f);
  EXPECT_EQ(a.points, CaptureFrame(*shape, 0, Small()).points);
}

TEST(CaptureTest, NoiseAndOutliersAreAsMuchAsAskedFor) {
  const auto shape = MakeBlob(1);
  CaptureOptions options = Small();
  options.noise = 0.01;
  const PointCloud noisy = CaptureFrame(*shape, 0, options);
  const double diagonal = BoundingBox(shape->Vertices(0)).diagonal();
  // Of three components, one is along the normal.
  const double rms = std::sqrt(Distances(*shape, noisy, 0).array().square().mean());
  EXPECT_NEAR(rms, 0.01 * diagonal, 0.002 * diagonal);
  options.noise = 0;
  options.outliers = 0.2;
  const Eigen::VectorXd distances = Distances(*shape, CaptureFrame(*shape, 0, options), 0);
  EXPECT_NEAR((distances.array() > 5e-3).cast<double>().mean(), 0.19, 0.04);
}

TEST(CaptureTest, OptionsOutOfRangeAreNamed) {
  CaptureOptions options;
  options.points = 3;
  EXPECT_EQ(options.Validate().message(), "points is 3; it must be from 16 to 5e+07");
  options = CaptureOptions();
  options.frames = 0;
  EXPECT_FALSE(options.Validate().ok());
  options = CaptureOptions();
  options.noise = -1;
  EXPECT_FALSE(options.Validate().ok());
  options = CaptureOptions();
  options.outliers = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(options.Validate().ok());
}

}  // namespace
}  // namespace cagefit::client
