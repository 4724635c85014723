#include "core/subdiv/limit_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "core/subdiv/limit.h"
#include "tests/core/subdiv/subdiv_samples.h"
#include "tests/core/subdiv/surface_samples.h"

namespace cagefit {
namespace {

using testing::RandomSurfacePoints;
using testing::SubdivSample;
using testing::SubdivSamples;

// Points of the limit mesh of `levels` refinements as (face, u, v): corners of its triangles.
std::vector<SurfacePoint> FinePoints(const Topology& topology, const Triangles& fine, int levels,
                                     std::vector<int32_t>* vertices) {
  // Weights of the fine triangles' corners in their control triangle, by the order of refine.h.
  struct Corner {
    Eigen::Vector3d w[3];
  };
  std::vector<Corner> corners(1);
  for (int k = 0; k < 3; ++k) corners[0].w[k] = Eigen::Vector3d::Unit(k);
  for (int level = 0; level < levels; ++level) {
    std::vector<Corner> next;
    for (const Corner& c : corners) {
      const Eigen::Vector3d e[3] = {(c.w[0] + c.w[1]) / 2, (c.w[1] + c.w[2]) / 2,
                                    (c.w[2] + c.w[0]) / 2};
      next.push_back({{c.w[0], e[0], e[2]}});
      next.push_back({{c.w[1], e[1], e[0]}});
      next.push_back({{c.w[2], e[2], e[1]}});
      next.push_back({{e[0], e[1], e[2]}});
    }
    corners.swap(next);
  }
  std::vector<SurfacePoint> points;
  const auto per_face = static_cast<int32_t>(corners.size());
  for (int32_t t = 0; t < fine.cols(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& w = corners[t % per_face].w[k];
      points.push_back({t / per_face, w[1], w[2]});
      vertices->push_back(fine(k, t));
    }
  }
  EXPECT_EQ(points.size(), 3u * per_face * topology.triangle_count());
  return points;
}

TEST(LimitSurfaceTest, AgreesWithTheLimitMeshOfFourRefinements) {
  for (const SubdivSample& sample : SubdivSamples()) {
    SCOPED_TRACE(sample.name);
    constexpr int kLevels = 4;
    const LimitMesh mesh = BuildLimitMesh(sample.topology, sample.tags, kLevels);
    Points3d expected;
    ApplyStencils(mesh.position, sample.V, &expected);
    std::vector<int32_t> vertices;
    const std::vector<SurfacePoint> points =
        FinePoints(sample.topology, mesh.triangles, kLevels, &vertices);
    const LimitSurface surface(sample.topology, sample.tags);
    Points3d control_points;
    surface.ControlPoints(sample.V, &control_points);
    const auto stencils = surface.Stencils(points, Derivatives::kNone);
    ASSERT_TRUE(stencils.ok()) << stencils.status();
    Points3d by_rows;
    ApplyStencils(stencils->position, sample.V, &by_rows);
    double worst = 0, worst_row = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3d q = expected.col(vertices[i]);
      const SurfaceJet jet = surface.Evaluate(control_points, points[i], Derivatives::kNone);
      worst = std::max(worst, (jet.position - q).norm());
      worst_row = std::max(worst_row, (by_rows.col(static_cast<int64_t>(i)) - q).norm());
    }
    const double diagonal = BoundingBox(sample.V).diagonal();
    EXPECT_LT(worst, 1e-12 * diagonal);
    EXPECT_LT(worst_row, 1e-12 * diagonal);
  }
}

TEST(LimitSurfaceTest, RowsSumToOneAndThoseOfDerivativesToZero) {
  for (const SubdivSample& sample : SubdivSamples()) {
    SCOPED_TRACE(sample.name);
    const LimitSurface surface(sample.topology, sample.tags);
    const auto stencils =
        surface.Stencils(RandomSurfacePoints(sample.topology, 500, 7), Derivatives::kSecond);
    ASSERT_TRUE(stencils.ok()) << stencils.status();
    const auto worst = [&](const StencilMatrix& S, double sum) {
      return (S * Eigen::VectorXd::Ones(S.cols()) - Eigen::VectorXd::Constant(S.rows(), sum))
          .lpNorm<Eigen::Infinity>();
    };
    EXPECT_LT(worst(stencils->position, 1), 1e-12);
    for (const StencilMatrix* S : {&stencils->du, &stencils->dv}) EXPECT_LT(worst(*S, 0), 1e-12);
    for (const StencilMatrix* S : {&stencils->duu, &stencils->duv, &stencils->dvv}) {
      EXPECT_LT(worst(*S, 0), 1e-9);
    }
  }
}

TEST(LimitSurfaceTest, DerivativesAreThoseOfFiniteDifferences) {
  constexpr double kStep = 1e-5;
  for (const SubdivSample& sample : SubdivSamples()) {
    SCOPED_TRACE(sample.name);
    const LimitSurface surface(sample.topology, sample.tags);
    Points3d control_points;
    surface.ControlPoints(sample.V, &control_points);
    const double diagonal = BoundingBox(sample.V).diagonal();
    for (const SurfacePoint& p : RandomSurfacePoints(sample.topology, 300, 11)) {
      // Within one box spline, away from its edges.
      const double w = 1 - p.u - p.v;
      if (std::min({p.u, p.v, w, std::abs(p.u - 0.5), std::abs(p.v - 0.5), std::abs(w - 0.5)}) <
          0.02) {
        continue;
      }
      const auto at = [&](double du, double dv) {
        return surface.Evaluate(control_points, {p.face, p.u + du, p.v + dv}, Derivatives::kSecond);
      };
      const SurfaceJet jet = at(0, 0);
      const SurfaceJet right = at(kStep, 0), left = at(-kStep, 0), up = at(0, kStep),
                       down = at(0, -kStep);
      const auto error = [&](const Eigen::Vector3d& value, const Eigen::Vector3d& a,
                             const Eigen::Vector3d& b) {
        return (value - (a - b) / (2 * kStep)).norm() / diagonal;
      };
      EXPECT_LT(error(jet.du, right.position, left.position), 1e-7);
      EXPECT_LT(error(jet.dv, up.position, down.position), 1e-7);
      EXPECT_LT(error(jet.duu, right.du, left.du), 1e-6);
      EXPECT_LT(error(jet.duv, up.du, down.du), 1e-6);
      EXPECT_LT(error(jet.dvv, up.dv, down.dv), 1e-6);
    }
  }
}

}  // namespace
}  // namespace cagefit
