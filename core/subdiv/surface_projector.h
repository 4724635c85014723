// Closest points on the limit surface.
//
// The nearest point of the limit mesh of one refinement (limit.h) starts a descent on the exact
// surface (foot_search.h).
#ifndef CAGEFIT_CORE_SUBDIV_SURFACE_PROJECTOR_H_
#define CAGEFIT_CORE_SUBDIV_SURFACE_PROJECTOR_H_

#include <vector>

#include "core/mesh/triangle_bvh.h"
#include "core/subdiv/limit.h"
#include "core/subdiv/limit_surface.h"
#include "core/subdiv/surface_foot.h"

namespace cagefit {

class SurfaceProjector {
 public:
  // Where a foot lies is known to about this, relative to the longest edge of its control triangle.
  static constexpr double kTolerance = 1e-9;

  // `surface` must outlive the object; `tags` are those that it was made with.
  SurfaceProjector(const LimitSurface* surface, const CreaseTags& tags,
                   double tolerance = kTolerance);

  // Sets the control vertices (3 x n, finite); required before the rest. Buffers keep their
  // capacity.
  void SetVertices(const Points3d& V);
  // The same, but cheaper: Closest goes on to start where the foot was at the vertices set before.
  void MoveVertices(const Points3d& V) { surface_->ControlPoints(V, &control_points_); }

  // The foot of x (finite). Of parts of the surface that are equally near to within twice the
  // distance between surface and limit mesh, either may be taken. Thread-safe, as is the rest;
  // nothing is allocated but at valences above 18.
  SurfaceFoot Closest(const Eigen::Vector3d& x) const;

  // The foot that the descent from `start`, a valid point of the surface, leads to: a local one.
  // A start near it, such as the last step's foot, makes it the fastest way.
  SurfaceFoot Track(const Eigen::Vector3d& x, const SurfacePoint& start) const;

  // The same for the columns of X, in parallel. `feet` is resized to them; Track starts from
  // (*feet)[i].at.
  void Closest(const Points3d& X, std::vector<SurfaceFoot>* feet) const;
  void Track(const Points3d& X, std::vector<SurfaceFoot>* feet) const;

  const LimitSurface& surface() const { return *surface_; }
  // LimitSurface::ControlPoints of the vertices set last.
  const Points3d& control_points() const { return control_points_; }

 private:
  const LimitSurface* surface_;
  double tolerance_;
  LimitMesh mesh_;
  Points3d control_points_, mesh_vertices_;
  TriangleBvh bvh_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_SURFACE_PROJECTOR_H_
