#include "core/subdiv/shaded_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "core/mesh/triangle_mesh.h"
#include "core/subdiv/child_point.h"
#include "core/subdiv/limit.h"
#include "core/subdiv/limit_surface.h"
#include "core/subdiv/refine.h"
#include "core/subdiv/sharp_features.h"

namespace cagefit {
namespace {

// |du x dv| over |du| |dv|, below which there is no tangent plane.
constexpr double kLeastSine = 1e-9;

// Corner c of triangle t of the mesh refined `levels` times.
SurfacePoint CornerPoint(int32_t t, int c, int levels) {
  ChildPoint point = {0, c == 1 ? 1.0 : 0.0, c == 2 ? 1.0 : 0.0};
  for (int level = 0; level < levels; ++level, t /= 4) {
    point.child = t % 4;
    const Eigen::Vector2d uv = FromChild(point);
    point = {0, uv[0], uv[1]};
  }
  return {t, point.u, point.v};
}

// Corners of triangles, joined where the surface is smooth between them.
class Sectors {
 public:
  Sectors(const Topology& topology, const CreaseTags& tags) : parent_(topology.triangles().size()) {
    std::iota(parent_.begin(), parent_.end(), 0);
    std::vector<char> sharp(topology.edge_count());
    for (const auto& [a, b] : tags.edges) sharp[topology.FindEdge(a, b)] = 1;
    for (int32_t h = 0; h < static_cast<int32_t>(parent_.size()); ++h) {
      const int32_t o = topology.opposite(h);
      if (o < h || sharp[topology.triangle_edge(h / 3, h % 3)]) continue;  // also on a boundary
      Join(h, Next(o));
      Join(Next(h), o);
    }
  }

  int32_t Find(int32_t corner) {
    while (parent_[corner] != corner) corner = parent_[corner] = parent_[parent_[corner]];
    return corner;
  }

 private:
  static int32_t Next(int32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }

  void Join(int32_t a, int32_t b) {
    a = Find(a), b = Find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  std::vector<int32_t> parent_;
};

}  // namespace

ShadedMesh::ShadedMesh(const ControlMesh& cage, int levels) {
  LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), levels);
  limit_.swap(limit.position);  // sparse matrices of Eigen 3.4 are not moved
  limit_triangles_ = std::move(limit.triangles);
  std::optional<Refinement> fine;
  for (int level = 0; level < levels; ++level) {
    fine = RefineOnce(fine ? fine->topology : cage.topology(), fine ? fine->tags : cage.tags());
  }
  Sectors sectors(fine ? fine->topology : cage.topology(), fine ? fine->tags : cage.tags());

  triangles_.resize(3, limit_triangles_.cols());
  std::vector<int32_t> vertex_of(triangles_.size(), -1);  // by the first corner of a sector
  std::vector<SurfacePoint> points;
  for (int32_t h = 0; h < static_cast<int32_t>(triangles_.size()); ++h) {
    int32_t& vertex = vertex_of[sectors.Find(h)];
    if (vertex < 0) {
      vertex = static_cast<int32_t>(points.size());
      points.push_back(CornerPoint(h / 3, h % 3, levels));
      limit_vertices_.push_back(limit_triangles_.data()[h]);
    }
    triangles_.data()[h] = vertex;
  }
  const SharpFeatures sharp = FindSharpFeatures(cage.topology(), cage.tags());
  for (const int32_t v : limit_vertices_) {
    is_tip_.push_back(v < cage.vertex_count() && sharp.vertex_rule[v] == VertexRule::kCorner);
  }
  // Points on corners of triangles are valid.
  SurfaceStencils stencils =
      LimitSurface(cage.topology(), cage.tags()).Stencils(points, Derivatives::kFirst).value();
  du_.swap(stencils.du);
  dv_.swap(stencils.dv);
}

void ShadedMesh::Evaluate(const Points3d& V, Points3d* positions, Points3d* normals) const {
  const auto count = static_cast<Eigen::Index>(limit_vertices_.size());
  Points3d limit, du, dv;
  ApplyStencils(limit_, V, &limit);
  ApplyStencils(du_, V, &du);
  ApplyStencils(dv_, V, &dv);
  positions->resize(3, count);
  normals->resize(3, count);
  Points3d of_triangles;
  for (Eigen::Index k = 0; k < count; ++k) positions->col(k) = limit.col(limit_vertices_[k]);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Vector3d normal = du.col(k).cross(dv.col(k));
    if (!is_tip_[k] && normal.norm() > kLeastSine * du.col(k).norm() * dv.col(k).norm()) {
      normals->col(k) = normal.normalized();
      continue;
    }
    if (of_triangles.cols() == 0) of_triangles = VertexNormals({*positions, triangles_});
    normals->col(k) = of_triangles.col(k);
  }
}

}  // namespace cagefit
