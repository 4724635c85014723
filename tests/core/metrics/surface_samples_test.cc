#include "core/metrics/surface_samples.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"

namespace cagefit {
namespace {

TEST(SurfaceSamplesTest, UsedVerticesComeFirst) {
  TriangleMesh mesh = testing::OpenGrid(1);
  mesh.vertices.conservativeResize(3, 5);
  mesh.vertices.col(4) << 9, 9, 9;  // used by no triangle
  const Points3d samples = SampleSurface(mesh, 3, 1);
  ASSERT_EQ(samples.cols(), 4 + 3 * 2);
  EXPECT_EQ(samples.leftCols(4), mesh.vertices.leftCols(4));
  EXPECT_LE(samples.maxCoeff(), 1);
}

TEST(SurfaceSamplesTest, FallUniformlyByArea) {
  // Two triangles in z = 0, the second nine times as large as the first.
  TriangleMesh mesh;
  mesh.vertices.resize(3, 6);
  mesh.vertices << 0, 1, 0, 10, 13, 10, 0, 0, 1, 0, 0, 3, 0, 0, 0, 0, 0, 0;
  mesh.triangles.resize(3, 2);
  mesh.triangles << 0, 3, 1, 4, 2, 5;
  const Points3d samples = SampleSurface(mesh, 20'000, 7).rightCols(40'000);
  const double share = (samples.row(0).array() > 5).cast<double>().mean();
  EXPECT_NEAR(share, 0.9, 0.01);
  // The mean of uniform points of a triangle is its middle.
  EXPECT_NEAR(
      (samples.row(0).array() > 5).select(samples.row(0).array(), 0.0).sum() / (share * 40'000), 11,
      0.02);
}

TEST(SurfaceSamplesTest, AreTheSameForOneSeed) {
  const TriangleMesh sphere = testing::Icosphere(1);
  EXPECT_EQ(SampleSurface(sphere, 5, 3), SampleSurface(sphere, 5, 3));
  EXPECT_NE(SampleSurface(sphere, 5, 3), SampleSurface(sphere, 5, 4));
}

TEST(SurfaceSamplesTest, NoAreaMeansVerticesAlone) {
  TriangleMesh flat = testing::OpenGrid(1);
  flat.vertices.setZero();
  EXPECT_EQ(SampleSurface(flat, 5, 1).cols(), 4);
}

}  // namespace
}  // namespace cagefit
