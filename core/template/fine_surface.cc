#include "core/template/fine_surface.h"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <vector>

#include "core/mesh/topology.h"

namespace cagefit {

namespace {

constexpr double kAlongCosine = 0.5;

}  // namespace

FineSurface::FineSurface(const TaggedMesh& fine)
    : diagonal_(BoundingBox(fine.mesh.vertices).diagonal()),
      surface_(fine.mesh.vertices, fine.mesh.triangles) {
  const Points3d& V = fine.mesh.vertices;
  const Triangles& T = fine.mesh.triangles;
  normals_.resize(3, T.cols());
  for (int64_t f = 0; f < T.cols(); ++f) {
    normals_.col(f) =
        (V.col(T(1, f)) - V.col(T(0, f))).cross(V.col(T(2, f)) - V.col(T(0, f))).stableNormalized();
  }
  std::vector<std::array<int32_t, 2>> edges = fine.tags.edges;
  const auto topology = Topology::Create(static_cast<int32_t>(V.cols()), T);
  for (int32_t e = 0; topology.ok() && e < topology->edge_count(); ++e) {
    if (topology->IsBoundaryEdge(e)) edges.push_back(topology->edge(e));
  }
  Triangles segments(3, static_cast<int64_t>(edges.size()));
  directions_.resize(3, segments.cols());
  for (int64_t e = 0; e < segments.cols(); ++e) {
    const auto& [a, b] = edges[e];
    segments.col(e) << a, b, b;  // acts as an edge
    directions_.col(e) = (V.col(b) - V.col(a)).stableNormalized();
  }
  if (segments.cols() > 0) curves_.Build(V, segments);
}

std::optional<Eigen::Vector3d> FineSurface::Nearest(const Eigen::Vector3d& x, double reach) const {
  const ClosestPoint closest = surface_.Closest(x, reach);
  if (closest.triangle < 0) return std::nullopt;
  return closest.point;
}

Eigen::Vector3d FineSurface::NormalAt(const Eigen::Vector3d& x) const {
  const ClosestPoint closest = surface_.Closest(x);
  if (closest.triangle < 0) return Eigen::Vector3d::Zero();
  return normals_.col(closest.triangle);
}

std::optional<Eigen::Vector3d> FineSurface::NearestOnCurve(const Eigen::Vector3d& x,
                                                           const Eigen::Vector3d& along,
                                                           double reach) const {
  if (curves_.empty()) return std::nullopt;
  const ClosestPoint closest = curves_.Closest(x, reach);
  if (closest.triangle < 0) return std::nullopt;
  const double cosine = std::abs(directions_.col(closest.triangle).dot(along));
  if (!(cosine >= kAlongCosine * along.norm())) return std::nullopt;
  return closest.point;
}

}  // namespace cagefit
