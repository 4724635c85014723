// The surface that a template is made from, onto which its vertices come back after a move.
#ifndef CAGEFIT_CORE_TEMPLATE_FINE_SURFACE_H_
#define CAGEFIT_CORE_TEMPLATE_FINE_SURFACE_H_

#include <optional>

#include "core/mesh/triangle_bvh.h"
#include "core/template/tagged_mesh.h"

namespace cagefit {

// Copies what it needs; thread-safe. Curves are the boundaries and creases.
class FineSurface {
 public:
  explicit FineSurface(const TaggedMesh& fine);

  double diagonal() const { return diagonal_; }  // of the bounding box

  // The point of the surface nearest to x, within `reach`.
  std::optional<Eigen::Vector3d> Nearest(const Eigen::Vector3d& x, double reach) const;
  // The unit normal of the triangle nearest to x, (0, 0, 0) where it has none.
  Eigen::Vector3d NormalAt(const Eigen::Vector3d& x) const;
  // The point of the curves nearest to x, within `reach`, if the curve runs within 60 degrees of
  // `along` there.
  std::optional<Eigen::Vector3d> NearestOnCurve(const Eigen::Vector3d& x,
                                                const Eigen::Vector3d& along, double reach) const;

 private:
  double diagonal_ = 0;
  Points3d normals_;     // of the triangles
  Points3d directions_;  // of the curves' edges, unit
  TriangleBvh surface_, curves_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_FINE_SURFACE_H_
