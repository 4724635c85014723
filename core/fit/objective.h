// The energy that every solver minimises: E_dist + alpha E_reg over the control vertices, in unit
// coordinates.
#ifndef CAGEFIT_CORE_FIT_OBJECTIVE_H_
#define CAGEFIT_CORE_FIT_OBJECTIVE_H_

#include <vector>

#include "core/energy/arap_term.h"
#include "core/energy/distance_term.h"
#include "core/fit/energies.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

// Not thread-safe. Structure is built once; SetTarget and SetRest replace numbers.
class Objective {
 public:
  // S: m samples x n control vertices.
  Objective(const Topology& topology, StencilMatrix S, double arap_weight);

  void SetTarget(const TargetIndex* target, double far_radius);
  void SetRest(const Points3d& rest) { arap_.SetRest(rest); }

  // Chooses radius and branch of every sample at V (3 x n), where Evaluate was last called or the
  // target is new, and returns the energies under that choice with half their gradient (3 x n).
  Energies Assign(const Points3d& V, Points3d* half_gradient);

  // Energies at V with radius and branch of the last Assign, and half their gradient (3 x n).
  Energies Evaluate(const Points3d& V, Points3d* half_gradient);

  // As Evaluate, at V where the objective was last evaluated or assigned: after another alpha was
  // set. Takes the distances from there.
  Energies Reevaluate(const Points3d& V, Points3d* half_gradient);

  // Of the last evaluation.
  const std::vector<SampleResiduals>& residuals() const { return residuals_; }
  const DistanceTerm& distance() const { return distance_; }
  const ArapTerm& arap() const { return arap_; }
  double arap_weight() const { return arap_weight_; }  // alpha
  void set_arap_weight(double weight) { arap_weight_ = weight; }
  const StencilMatrix& stencils() const { return S_; }
  const StencilMatrix& stencils_transposed() const { return St_; }

 private:
  StencilMatrix S_, St_;  // m x n and n x m
  double arap_weight_;
  DistanceTerm distance_;
  ArapTerm arap_;
  Points3d Q_;
  std::vector<SampleResiduals> residuals_;
  double distance_energy_ = 0;  // of residuals_
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_OBJECTIVE_H_
