// The limit surface is one smooth surface: its triangles agree where they meet, and its normals at
// vertices are those that the normals beside them tend to.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/subdiv/corner_fan.h"
#include "core/subdiv/limit_surface.h"
#include "core/subdiv/refine.h"
#include "core/subdiv/sharp_features.h"
#include "tests/core/subdiv/subdiv_samples.h"
#include "tests/core/subdiv/surface_samples.h"
#include "tests/support/data.h"

namespace cagefit {
namespace {

using testing::Angle;
using testing::Corner;
using testing::Hubs;
using testing::Ours;
using testing::SubdivSample;

// Corners of triangles where the surface has a tangent plane: not corners of three or more
// triangles.
std::vector<SurfacePoint> SmoothCorners(const SubdivSample& sample) {
  const SharpFeatures sharp = FindSharpFeatures(sample.topology, sample.tags);
  std::vector<SurfacePoint> corners;
  for (int32_t f = 0; f < sample.topology.triangle_count(); ++f) {
    for (int c = 0; c < 3; ++c) {
      if (sharp.vertex_rule[sample.topology.triangles()(c, f)] != VertexRule::kCorner ||
          WalkCornerFan(sample.topology, sharp, f, c).faces() <= 2) {
        corners.push_back(Corner(f, c));
      }
    }
  }
  return corners;
}

// The masks of tangents are eigenvectors of refinement: at the same vertex of the mesh refined once
// they give the same plane.
TEST(LimitSurfaceContinuityTest, RefiningKeepsTheNormalsOfVertices) {
  std::vector<SubdivSample> samples = testing::SubdivSamples();
  samples.push_back(Hubs());
  for (const SubdivSample& sample : samples) {
    SCOPED_TRACE(sample.name);
    const Refinement refined = RefineOnce(sample.topology, sample.tags);
    SubdivSample fine = {"", {}, refined.topology, refined.tags};
    ApplyStencils(refined.matrix, sample.V, &fine.V);
    const std::vector<SurfacePoint> coarse_points = SmoothCorners(sample);
    std::vector<SurfacePoint> fine_points;
    for (const SurfacePoint& p : coarse_points) {
      fine_points.push_back({4 * p.face + (p.u == 1 ? 1 : p.v == 1 ? 2 : 0), 0, 0});
    }
    const std::vector<SurfaceJet> a = Ours(sample, coarse_points, Derivatives::kFirst),
                                  b = Ours(fine, fine_points, Derivatives::kFirst);
    for (size_t k = 0; k < a.size(); ++k) {
      EXPECT_LT(Angle(a[k], b[k]), 1e-9)
          << "face " << coarse_points[k].face << " vertex "
          << sample.topology.triangles().col(coarse_points[k].face).transpose();
    }
  }
}

// As near a vertex as doubles allow, normals have turned towards its own; slowly where the valence
// is high, so that a mean says more than the largest.
TEST(LimitSurfaceContinuityTest, NormalsBesideVerticesTendToTheirs) {
  for (const SubdivSample& sample : testing::SubdivSamples()) {
    SCOPED_TRACE(sample.name);
    const std::vector<SurfacePoint> vertices = SmoothCorners(sample);
    const std::vector<SurfaceJet> at = Ours(sample, vertices, Derivatives::kFirst);
    const auto mean_angle = [&](double distance) {
      std::vector<SurfacePoint> beside;
      for (const SurfacePoint& p : vertices) {
        beside.push_back({p.face, p.u + distance * (1 - 3 * p.u), p.v + distance * (1 - 3 * p.v)});
      }
      const std::vector<SurfaceJet> near = Ours(sample, beside, Derivatives::kFirst);
      double sum = 0;
      for (size_t i = 0; i < at.size(); ++i) sum += Angle(at[i], near[i]);
      return sum / static_cast<double>(at.size());
    };
    const double far = mean_angle(1e-3), near = mean_angle(1e-11);
    EXPECT_LT(near, 0.002);
    EXPECT_LT(near, 0.05 * far);
  }
}

// Ten points of every edge, seen from both sides: the same position and, but on creases, normal.
void ExpectContinuous(const SubdivSample& sample) {
  SCOPED_TRACE(sample.name);
  const LimitSurface surface(sample.topology, sample.tags);
  Points3d C;
  surface.ControlPoints(sample.V, &C);
  const std::vector<char> sharp = FindSharpFeatures(sample.topology, sample.tags).sharp_edge;
  double gap = 0, bend = 0;
  for (int32_t f = 0; f < sample.topology.triangle_count(); ++f) {
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 10; ++k) {
        const double t = (k + 0.5) / 10;
        const SurfacePoint here = c == 0   ? SurfacePoint{f, t, 0}
                                  : c == 1 ? SurfacePoint{f, 1 - t, t}
                                           : SurfacePoint{f, 0, 1 - t};
        const SurfacePoint there = surface.Across(here, c);
        if (there.face < f) continue;  // seen, or a boundary
        const SurfaceJet a = surface.Evaluate(C, here, Derivatives::kFirst),
                         b = surface.Evaluate(C, there, Derivatives::kFirst);
        gap = std::max(gap, (a.position - b.position).norm());
        if (!sharp[sample.topology.triangle_edge(f, c)]) bend = std::max(bend, Angle(a, b));
      }
    }
  }
  EXPECT_LT(gap, 1e-13 * BoundingBox(sample.V).diagonal());
  EXPECT_LT(bend, 1e-8);
}

TEST(LimitSurfaceContinuityTest, TrianglesAgreeAlongTheirEdges) {
  for (const SubdivSample& sample : testing::SubdivSamples()) ExpectContinuous(sample);
  ExpectContinuous(Hubs());
}

TEST(LimitSurfaceContinuityTest, TrianglesOfModelsAgreeAlongTheirEdges) {
  CAGEFIT_NEEDS_DATA();
  for (const SubdivSample& model : testing::SurfaceModels()) ExpectContinuous(model);
}

}  // namespace
}  // namespace cagefit
