// Damped Gauss-Newton (Levenberg-Marquardt) [nocedal2006, 10.3] with inexact steps.
#ifndef CAGEFIT_CORE_FIT_GAUSS_NEWTON_H_
#define CAGEFIT_CORE_FIT_GAUSS_NEWTON_H_

#include "absl/status/statusor.h"
#include "core/base/cancel.h"
#include "core/fit/fit_options.h"
#include "core/fit/objective.h"
#include "core/fit/step_system.h"

namespace cagefit {

struct Minimization {
  Energies initial, final;
  int iterations = 0;         // steps tried
  int linear_iterations = 0;  // conjugate gradient iterations in all steps
  bool converged = false;
};

// Minimises the objective from *V (3 x n, unit coordinates), which it replaces by the minimiser.
// Radius and branch of every sample, and the feet of covered points, are chosen anew after each
// accepted step. The first steps see a coarser problem: alpha is options.first_stiffness times too
// high and falls by a factor of 4 a step, radii are `first_radius` times too large and halve, and
// the kernel's scale follows both. CANCELLED within one
// step, INTERNAL when energy or step are not finite; *V is then unspecified.
absl::StatusOr<Minimization> MinimizeGaussNewton(const SolverOptions& options,
                                                 const CancelFn& cancelled, Objective* objective,
                                                 StepSystem* system, Points3d* V,
                                                 double first_radius = 1);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_GAUSS_NEWTON_H_
