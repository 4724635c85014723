#include "server/session/stencil_export.h"

#include <gtest/gtest.h>

#include "core/fit/fitter.h"
#include "core/subdiv/limit.h"
#include "core/subdiv/surface_sampler.h"
#include "server/session/error_detail.h"
#include "tests/support/frames.h"

namespace cagefit::server {
namespace {

using cagefit::testing::FrameCage;

void ExpectEqual(const StencilMatrix& a, const StencilMatrix& b) {
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_EQ(a.cols(), b.cols());
  EXPECT_EQ((a - b).norm(), 0);
  EXPECT_TRUE(a.isCompressed());
}

TEST(StencilExportTest, WithoutLevelsTheyAreTheSamplesOfTheFit) {
  const ControlMesh cage = FrameCage();
  DistanceOptions distance;
  for (const Sampling sampling :
       {Sampling::kControlVertices, Sampling::kRefinedVertices, Sampling::kArea}) {
    distance.sampling = sampling;
    distance.samples_per_triangle = 3;
    const auto stencils = ExportStencils(cage, distance, StencilExportOptions());
    ASSERT_TRUE(stencils.ok()) << stencils.status();
    ExpectEqual(stencils->S, *FitSamples(cage, distance));
    EXPECT_EQ(stencils->triangles.cols(), 0);
  }
}

TEST(StencilExportTest, WithLevelsTheyAreTheRefinedVerticesAtTheirLimit) {
  const ControlMesh cage = FrameCage();
  for (const uint32_t levels : {0u, 1u, 3u}) {
    StencilExportOptions options;
    options.levels = levels;
    const auto stencils = ExportStencils(cage, DistanceOptions(), options);
    ASSERT_TRUE(stencils.ok()) << stencils.status();
    const LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), static_cast<int>(levels));
    ExpectEqual(stencils->S, limit.position);
    EXPECT_EQ(stencils->triangles, limit.triangles);
    EXPECT_EQ(stencils->triangles.cols(), 80 << (2 * levels));
    EXPECT_EQ(stencils->triangles.maxCoeff(), stencils->S.rows() - 1);
  }
}

TEST(StencilExportTest, RefusesTooManyLevelsTrianglesAndEntries) {
  StencilExportOptions options;
  options.levels = 6;
  absl::Status status = ExportStencils(FrameCage(), DistanceOptions(), options).status();
  EXPECT_TRUE(absl::IsInvalidArgument(status)) << status;
  EXPECT_EQ(DetailOf(status)->field, "levels");
  options.levels = 1;
  options.max_triangles = 319;
  status = ExportStencils(FrameCage(), DistanceOptions(), options).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(DetailOf(status)->value, "320");
  options.max_triangles = 320;
  EXPECT_TRUE(ExportStencils(FrameCage(), DistanceOptions(), options).ok());
  options.max_entries = 100;
  status = ExportStencils(FrameCage(), DistanceOptions(), options).status();
  EXPECT_TRUE(absl::IsResourceExhausted(status)) << status;
  EXPECT_EQ(DetailOf(status)->field, "entries of the stencils");
}

}  // namespace
}  // namespace cagefit::server
