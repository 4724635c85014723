#include "server/session/surface_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/codec/draco_codec.h"
#include "core/subdiv/refine.h"
#include "server/session/error_detail.h"
#include "tests/support/frames.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameCage;

// The limit surface by another way than the exporter's: only the stencils are shared.
Points3d LimitPoints(const ControlMesh& mesh, int levels) {
  Points3d points;
  ApplyStencils(BuildLimitMesh(mesh.topology(), mesh.tags(), levels).position, mesh.vertices(),
                &points);
  return points;
}

TEST(SurfaceExportTest, SendsTheRefinedLimitSurfaceWithoutLoss) {
  const ControlMesh cage = FrameCage();
  for (const uint32_t levels : {0u, 1u, 2u, 3u}) {
    SurfaceExportOptions options;
    options.levels = levels;
    const auto bytes = ExportSurface(cage, options);
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    const auto surface = DecodeDracoMesh(*bytes, DecodeLimits());
    ASSERT_TRUE(surface.ok()) << surface.status();
    EXPECT_EQ(surface->triangles.cols(), 80 << (2 * levels));
    EXPECT_EQ(surface->vertices,
              LimitPoints(cage, static_cast<int>(levels)).cast<float>().cast<double>());
  }
}

TEST(SurfaceExportTest, QuantizesOnRequest) {
  const ControlMesh cage = FrameCage();
  SurfaceExportOptions options;
  const size_t lossless_bytes = ExportSurface(cage, options)->size();
  options.position_bits = 10;
  const auto bytes = ExportSurface(cage, options);
  ASSERT_TRUE(bytes.ok()) << bytes.status();
  EXPECT_LT(bytes->size(), lossless_bytes);
  const auto surface = DecodeDracoMesh(*bytes, DecodeLimits());
  ASSERT_TRUE(surface.ok()) << surface.status();
  const Points3d exact = LimitPoints(cage, 2);
  const double step = BoundingBox(exact).size().maxCoeff() / 1023;
  const double error = (surface->vertices - exact).cwiseAbs().maxCoeff();
  EXPECT_LE(error, 0.51 * step);
  EXPECT_GT(error, 0.1 * step);
}

TEST(SurfaceExportTest, NamesABadField) {
  SurfaceExportOptions levels;
  levels.levels = 6;
  EXPECT_EQ(ExportSurface(FrameCage(), levels).status().message(), "levels is 6; expected 0 to 5");
  for (const uint32_t bits : {1u, 7u, 31u}) {
    SurfaceExportOptions options;
    options.position_bits = bits;
    const absl::Status status = ExportSurface(FrameCage(), options).status();
    EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
    EXPECT_EQ(DetailOf(status)->field, "position_bits");
  }
}

TEST(SurfaceExportTest, RefusesMoreTrianglesThanItsLimit) {
  SurfaceExportOptions options;
  options.levels = 1;
  options.max_triangles = 320;
  EXPECT_TRUE(ExportSurface(FrameCage(), options).ok());
  options.max_triangles = 319;
  const absl::Status status = ExportSurface(FrameCage(), options).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(DetailOf(status)->value, "320");
  EXPECT_EQ(DetailOf(status)->limit, "319");
}

}  // namespace
}  // namespace cagefit::server
