// Levenberg-Marquardt by Ceres on the same residuals: the reference that checks the other solvers
// on small meshes.
#ifndef CAGEFIT_CORE_FIT_CERES_SOLVER_H_
#define CAGEFIT_CORE_FIT_CERES_SOLVER_H_

#include "absl/status/statusor.h"
#include "core/base/cancel.h"
#include "core/fit/gauss_newton.h"
#include "core/fit/objective.h"

namespace cagefit {

// As MinimizeGaussNewton, but radius and branch are chosen anew only when Ceres has converged under
// the choice before. The feet of covered points follow each step; one that lowers the energy under
// the old feet only is taken back. `iterations` counts Ceres' steps.
absl::StatusOr<Minimization> MinimizeCeres(const SolverOptions& options, const CancelFn& cancelled,
                                           Objective* objective, Points3d* V);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_CERES_SOLVER_H_
