// The open boundary of the surface, drawn to that of the target:
//
//   E_bound = eta (n/B) sum_b | (I - t_b t_b^T) (X_b - p_b) |^2
//
// n control vertices, B points X_b of the limit surface's boundary, kPointsPerEdge to each boundary
// edge of the control mesh, p_b the point of the target's boundary nearest to X_b, t_b the
// boundary's direction there: what lies along the boundary costs nothing.
//
// p_b and t_b are chosen by Assign and held fixed for value and gradient. A point whose p_b is
// farther away than kReach mean edges of the control mesh, or belongs to a sheet that faces the
// other way, takes no part: the target may lack that boundary.
#ifndef CAGEFIT_CORE_ENERGY_BOUNDARY_TERM_H_
#define CAGEFIT_CORE_ENERGY_BOUNDARY_TERM_H_

#include <memory>
#include <optional>
#include <vector>

#include "core/cloud/kd_tree.h"
#include "core/energy/attachments.h"
#include "core/energy/boundary_curve.h"
#include "core/mesh/control_mesh.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

// Not thread-safe. Structure is built once.
class BoundaryTerm {
 public:
  static constexpr int kPointsPerEdge = 2;
  static constexpr double kReach = 2;

  BoundaryTerm(const Topology& topology, const CreaseTags& tags);

  // `curve` outlives the term's use of it. `weight` is eta; with 0, without a curve, or on a closed
  // surface there are no attachments.
  void SetTarget(const BoundaryCurve* curve, double weight);
  bool is_on() const { return attachments_.size() > 0; }

  // Chooses p_b and t_b at V (3 x n).
  void Assign(const Points3d& V);
  const Attachments& attachments() const { return attachments_; }

 private:
  const Topology topology_;
  StencilMatrix position_, du_, dv_;  // B x n
  const BoundaryCurve* curve_ = nullptr;
  std::optional<KdTree> tree_;  // of curve_
  double weight_ = 0;
  Attachments attachments_;
  Points3d points_, tangents_u_, tangents_v_;  // at the last Assign
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_BOUNDARY_TERM_H_
