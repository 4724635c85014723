#include "core/fit/gauss_newton.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"

namespace cagefit {

namespace {

constexpr double kInitialDamping = 1e-5;  // of the mean diagonal
constexpr double kLeastDamping = 1e-8, kMostDamping = 1e6;
constexpr int kMaxLinearIterations = 400;
// A step is kept when the energy falls by at least this share of what the model promised.
constexpr double kLeastGain = 1e-3;

}  // namespace

absl::StatusOr<Minimization> MinimizeGaussNewton(const SolverOptions& options,
                                                 const CancelFn& cancelled, Objective* objective,
                                                 StepSystem* system, Points3d* V) {
  Minimization out;
  Points3d half_gradient, trial_half_gradient, step, trial;
  Energies energies = objective->Assign(*V, &half_gradient);
  out.initial = out.final = energies;
  if (!std::isfinite(energies.total())) {
    return absl::InternalError(absl::StrFormat("fit: initial energy is %g", energies.total()));
  }
  double damping = kInitialDamping;
  bool stale = true;  // the system does not hold the current linearisation
  // Loose solves early, tight ones near the minimum, where the quadratic model is exact enough to
  // deserve them.
  double linear_tolerance = 0.1;
  while (out.iterations < options.max_iterations && !out.converged) {
    if (IsCancelled(cancelled)) return absl::CancelledError("fit: cancelled");
    if (stale) system->Linearize(*objective);
    stale = false;
    double promised = 0;
    out.linear_iterations += system->Solve(half_gradient, damping, linear_tolerance,
                                           kMaxLinearIterations, cancelled, &step, &promised);
    ++out.iterations;
    if (IsCancelled(cancelled)) return absl::CancelledError("fit: cancelled");
    if (!step.allFinite()) return absl::InternalError("fit: diverged, a step is not finite");
    if (!(promised > 0)) {  // the gradient has vanished
      out.converged = true;
      break;
    }
    trial = *V + step;
    const Energies tried = objective->Evaluate(trial, &trial_half_gradient);
    const double decrease = energies.total() - tried.total();
    if (!(decrease >= kLeastGain * promised)) {
      // At rounding level neither energy nor promise means anything any more.
      if (promised <= 1e-12 * energies.total() || damping >= kMostDamping) {
        out.converged = true;
        break;
      }
      damping = std::min(kMostDamping, damping * 10);
      continue;
    }
    V->swap(trial);
    damping = decrease > 0.5 * promised ? std::max(kLeastDamping, damping / 5) : damping;
    out.converged = decrease <= options.relative_decrease * energies.total();
    linear_tolerance = std::clamp(decrease / energies.total(), 1e-3, 0.1);
    energies = objective->Assign(*V, &half_gradient);
    stale = true;
    out.final = energies;
  }
  return out;
}

}  // namespace cagefit
