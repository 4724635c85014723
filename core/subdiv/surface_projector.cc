#include "core/subdiv/surface_projector.h"

#include "core/base/parallel.h"
#include "core/subdiv/child_point.h"
#include "core/subdiv/foot_search.h"

namespace cagefit {

namespace {
constexpr int64_t kGrain = 256;  // points a chunk
}  // namespace

SurfaceProjector::SurfaceProjector(const LimitSurface* surface, const CreaseTags& tags,
                                   double tolerance)
    : surface_(surface),
      tolerance_(tolerance),
      mesh_(BuildLimitMesh(surface->topology(), tags, 1)) {}

void SurfaceProjector::SetVertices(const Points3d& V) {
  MoveVertices(V);
  ApplyStencils(mesh_.position, V, &mesh_vertices_);
  bvh_.Build(mesh_vertices_, mesh_.triangles);
}

SurfaceFoot SurfaceProjector::Closest(const Eigen::Vector3d& x) const {
  const ClosestPoint nearest = bvh_.Closest(x);
  const Eigen::Vector2d start = FromChild({nearest.triangle % 4, nearest.u, nearest.v});
  return Track(x, {nearest.triangle / 4, start.x(), start.y()});
}

SurfaceFoot SurfaceProjector::Track(const Eigen::Vector3d& x, const SurfacePoint& start) const {
  return FootSearch(*surface_, control_points_, x, tolerance_).Run(start);
}

void SurfaceProjector::Closest(const Points3d& X, std::vector<SurfaceFoot>* feet) const {
  feet->resize(X.cols());
  ParallelFor(X.cols(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) (*feet)[i] = Closest(Eigen::Vector3d(X.col(i)));
  });
}

void SurfaceProjector::Track(const Points3d& X, std::vector<SurfaceFoot>* feet) const {
  feet->resize(X.cols());
  ParallelFor(X.cols(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) (*feet)[i] = Track(X.col(i), (*feet)[i].at);
  });
}

}  // namespace cagefit
