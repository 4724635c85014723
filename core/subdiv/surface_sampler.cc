#include "core/subdiv/surface_sampler.h"

#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/random.h"
#include "core/base/status.h"
#include "core/mesh/area_sampler.h"
#include "core/subdiv/child_point.h"
#include "core/subdiv/limit.h"
#include "core/subdiv/limit_surface.h"

namespace cagefit {

namespace {

constexpr int kLevels = 2;  // of the limit mesh whose area counts

// The point with weights (1 - u - v, u, v) in triangle t of a mesh refined kLevels times.
SurfacePoint FromFineTriangle(int32_t t, double u, double v) {
  for (int level = 0; level < kLevels; ++level, t /= 4) {
    const Eigen::Vector2d parent = FromChild({t % 4, u, v});
    u = parent.x();
    v = parent.y();
  }
  return {t, u, v};
}

}  // namespace

std::vector<SurfacePoint> ControlVertexPoints(const Topology& topology) {
  std::vector<SurfacePoint> points(topology.vertex_count());
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    for (int c = 0; c < 3; ++c) {
      points[topology.triangles()(c, f)] = {f, c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0};
    }
  }
  return points;
}

std::vector<SurfacePoint> RefinedVertexPoints(const Topology& topology) {
  std::vector<SurfacePoint> points = ControlVertexPoints(topology);
  const size_t n = points.size();
  points.resize(n + topology.edge_count());
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    for (int c = 0; c < 3; ++c) {
      points[n + topology.triangle_edge(f, c)] = {f, c == 2 ? 0.0 : 0.5, c == 0 ? 0.0 : 0.5};
    }
  }
  return points;
}

absl::StatusOr<std::vector<SurfacePoint>> AreaPoints(const Topology& topology,
                                                     const CreaseTags& tags, const Points3d& V,
                                                     int samples_per_triangle, uint64_t seed) {
  if (samples_per_triangle < 1) {
    return absl::InvalidArgumentError(
        absl::StrFormat("%d samples per triangle, not 1 or more", samples_per_triangle));
  }
  const LimitMesh mesh = BuildLimitMesh(topology, tags, kLevels);
  Points3d vertices;
  ApplyStencils(mesh.position, V, &vertices);
  const AreaSampler sampler(vertices, mesh.triangles);
  if (!sampler.has_area()) return absl::InvalidArgumentError("the limit surface has no area");
  std::vector<SurfacePoint> points(static_cast<size_t>(samples_per_triangle) *
                                   topology.triangle_count());
  const auto count = static_cast<double>(points.size());
  Random random(seed);
  const double offset = random.Uniform();
  for (size_t k = 0; k < points.size(); ++k) {
    const double share = (static_cast<double>(k) + offset) / count;
    const AreaSampler::Point point = sampler.DrawAt(share, &random);
    points[k] =
        FromFineTriangle(static_cast<int32_t>(point.triangle), point.weights[1], point.weights[2]);
  }
  return points;
}

absl::StatusOr<StencilMatrix> SampleStencils(const ControlMesh& mesh, Sampling sampling,
                                             int samples_per_triangle, uint64_t seed) {
  if (sampling == Sampling::kControlVertices) {
    return LimitPositionStencils(mesh.topology(), mesh.tags());
  }
  if (sampling == Sampling::kRefinedVertices) {
    return BuildLimitMesh(mesh.topology(), mesh.tags(), 1).position;
  }
  ASSIGN_OR_RETURN(
      const std::vector<SurfacePoint> points,
      AreaPoints(mesh.topology(), mesh.tags(), mesh.vertices(), samples_per_triangle, seed));
  ASSIGN_OR_RETURN(SurfaceStencils stencils,
                   LimitSurface(mesh.topology(), mesh.tags()).Stencils(points, Derivatives::kNone));
  return std::move(stencils.position);
}

}  // namespace cagefit
