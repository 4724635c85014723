#include "core/fit/adam.h"

#include <cmath>

#include "absl/strings/str_format.h"

namespace cagefit {

namespace {

constexpr double kBeta1 = 0.9, kBeta2 = 0.999, kEpsilon = 1e-8;
constexpr int kFeetInterval = 10;

}  // namespace

absl::StatusOr<Minimization> MinimizeAdam(const SolverOptions& options, const CancelFn& cancelled,
                                          Objective* objective, Points3d* V) {
  Minimization out;
  Points3d half_gradient, best = *V;
  Points3d m = Points3d::Zero(3, V->cols()), v = m;
  objective->UseAllViews();
  Energies energies = objective->Assign(*V, &half_gradient);
  const bool draws = objective->images() != nullptr && objective->images()->draws();
  out.initial = out.final = energies;
  double window_energy = energies.total();  // least energy a window ago
  double power1 = 1, power2 = 1;            // b1^t, b2^t
  while (out.iterations < options.max_iterations && !out.converged) {
    if (IsCancelled(cancelled)) return absl::CancelledError("fit: cancelled");
    if (!std::isfinite(energies.total())) {
      return absl::InternalError(
          absl::StrFormat("fit: diverged, the energy is %g", energies.total()));
    }
    ++out.iterations;
    power1 *= kBeta1;
    power2 *= kBeta2;
    const double rate = options.learning_rate / (1 - power1), share = 1 / (1 - power2);
    const auto g = 2 * half_gradient.array();
    m.array() = kBeta1 * m.array() + (1 - kBeta1) * g;
    v.array() = kBeta2 * v.array() + (1 - kBeta2) * g.square();
    V->array() -= rate * m.array() / ((share * v.array()).sqrt() + kEpsilon);

    objective->DrawViews(out.iterations);
    if (out.iterations % kAdamWindow == 0) objective->Calibrate(*V);
    energies = objective->AssignSamples(*V, &half_gradient);
    if (out.iterations % kFeetInterval == 0) energies = objective->Assign(*V, &half_gradient);
    if (draws) {
      // Energies of other views do not compare.
      if (out.iterations % kAdamWindow != 0 && out.iterations < options.max_iterations) continue;
      objective->UseAllViews();
      energies = objective->Evaluate(*V, &half_gradient);
    }
    if (energies.total() < out.final.total()) {
      out.final = energies;
      best = *V;
    }
    if (out.iterations % kAdamWindow == 0) {
      out.converged =
          window_energy - out.final.total() <= options.relative_decrease * window_energy;
      window_energy = out.final.total();
    }
  }
  V->swap(best);
  objective->UseAllViews();
  objective->AssignSamples(*V, &half_gradient);
  out.final = objective->Assign(*V, &half_gradient);
  return out;
}

}  // namespace cagefit
