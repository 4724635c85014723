// Adam [kingma2015] on the objective's gradient: what [xie2022] minimises with, and the baseline
// that the other solvers are measured against.
#ifndef CAGEFIT_CORE_FIT_ADAM_H_
#define CAGEFIT_CORE_FIT_ADAM_H_

#include "absl/status/statusor.h"
#include "core/base/cancel.h"
#include "core/fit/gauss_newton.h"
#include "core/fit/objective.h"

namespace cagefit {

// As MinimizeGaussNewton, but
//
//   m <- b1 m + (1 - b1) g,  v <- b2 v + (1 - b2) g^2,
//   V <- V - rate  m / (1 - b1^t) / (sqrt(v / (1 - b2^t)) + 1e-8),   b1 = 0.9, b2 = 0.999,
//
// per coordinate, with the gradient g at the choices of the moment: radius and branch of every
// sample are chosen in each iteration, the feet of covered points in every 10th. Ends after
// max_iterations, or once kAdamWindow iterations have lowered the least energy by less than
// relative_decrease in all. *V becomes the iterate of least energy. Where views are drawn they are
// others in each iteration, and the iterates of whole windows are compared on all of them.
inline constexpr int kAdamWindow = 100;
absl::StatusOr<Minimization> MinimizeAdam(const SolverOptions& options, const CancelFn& cancelled,
                                          Objective* objective, Points3d* V);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_ADAM_H_
