#include "core/fit/gauss_newton.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"

namespace cagefit {

namespace {

constexpr double kInitialDamping = 1e-5;  // of the mean diagonal
constexpr double kSlidingDamping = 1e-3;  // least where a step slid too far
// A rise by as many times what ends the solver, when feet are chosen anew, ends it as no fall does.
constexpr double kSmallRise = 5;
constexpr double kLeastDamping = 1e-8, kMostDamping = 1e6;
constexpr int kMaxLinearIterations = 400;
// Of the residual in each linear solve: a tighter one costs more than the steps that it saves.
constexpr double kLinearTolerance = 0.1;
constexpr double kRounding = 1e-12;
// Steps after which radius and branch are chosen anew. Where a radius doubles the energy jumps by a
// percent, and a few samples that go to and fro would keep it from ever settling. Feet always
// follow: held ones would let the surface slide away under them.
constexpr int kMaxAssignments = 30;
// A step is kept when the energy falls by at least this share of what the model promised.
constexpr double kLeastGain = 1e-3;
// The regulariser's weight starts `first_stiffness` times too high and falls by this factor with
// each accepted step.
constexpr double kStiffnessFactor = 4;
constexpr double kRadiusFactor = 2;

}  // namespace

absl::StatusOr<Minimization> MinimizeGaussNewton(const SolverOptions& options,
                                                 const CancelFn& cancelled, Objective* objective,
                                                 StepSystem* system, Points3d* V,
                                                 double first_radius) {
  Minimization out;
  Points3d half_gradient, step, trial;
  const double arap_weight = objective->arap_weight();
  double radius = first_radius, stiffness = options.first_stiffness;
  const auto set_coarseness = [&] {
    objective->set_arap_weight(stiffness * arap_weight);
    objective->SetCoarseness(radius, std::max(radius, std::sqrt(stiffness)),
                             stiffness > kStiffnessFactor || radius > 1);
  };
  set_coarseness();
  objective->UseAllViews();
  objective->set_arap_weight(arap_weight);
  out.initial = out.final = objective->Assign(*V, &half_gradient);
  if (!std::isfinite(out.initial.total())) {
    return absl::InternalError(absl::StrFormat("fit: initial energy is %g", out.initial.total()));
  }
  // Stiff first, so that what moved as a whole is carried as a whole; the details follow. Without
  // this the surface falls straight onto the target and then has to slide along it.
  objective->set_arap_weight(stiffness * arap_weight);
  const bool draws = objective->images() != nullptr && objective->images()->draws();
  objective->DrawViews(0);
  Energies energies =
      draws ? objective->Evaluate(*V, &half_gradient) : objective->Reevaluate(*V, &half_gradient);
  double judged = 0;  // energy by all views when it was last asked for; 0: never
  double damping = kInitialDamping;
  bool stale = true;       // the system does not hold the current linearisation
  bool elsewhere = false;  // the objective was last evaluated at a trial that was not taken
  while (out.iterations < options.max_iterations && !out.converged) {
    if (IsCancelled(cancelled)) break;
    if (stale) system->Linearize(*objective);
    stale = false;
    double promised = 0;
    out.linear_iterations += system->Solve(half_gradient, damping, kLinearTolerance,
                                           kMaxLinearIterations, cancelled, &step, &promised);
    ++out.iterations;
    if (IsCancelled(cancelled)) break;
    if (!step.allFinite()) {
      objective->set_arap_weight(arap_weight);
      return absl::InternalError("fit: diverged, a step is not finite");
    }
    trial = *V + step;
    const Energies tried = objective->Evaluate(trial, nullptr);
    const double decrease = energies.total() - tried.total();
    // At rounding level neither energy nor promise means anything any more.
    const bool exhausted = promised <= kRounding * energies.total() || damping >= kMostDamping;
    const bool accepted = decrease >= kLeastGain * promised && promised > 0;
    elsewhere = !accepted;
    if (!accepted && !exhausted) {
      damping = std::min(kMostDamping, damping * 10);
      continue;
    }
    if (accepted) {
      V->swap(trial);
      if (decrease > 0.5 * promised) damping = std::max(kLeastDamping, damping / 5);
    } else {
      objective->Evaluate(*V, &half_gradient);
      elsewhere = false;
    }
    // Judged on what is left after new choices: held ones promise more than they keep where feet
    // slide along a curved surface.
    const bool finest = stiffness <= 1 && radius <= 1;
    const double before = energies.total();
    stiffness = std::max(1.0, stiffness / kStiffnessFactor);
    radius = std::max(1.0, radius / kRadiusFactor);
    set_coarseness();
    objective->DrawViews(out.iterations);
    energies = out.iterations < kMaxAssignments ? objective->Assign(*V, &half_gradient)
                                                : objective->AssignFeet(*V, &half_gradient);
    stale = true;
    const double least = options.relative_decrease * before;
    if (draws) {
      // Energies of other views do not compare. Where those of one set end, all are asked.
      if (!finest || (!exhausted && decrease > least)) continue;
      objective->UseAllViews();
      const double all = objective->Evaluate(*V, nullptr).total();
      out.converged = exhausted || (judged > 0 && judged - all <= options.relative_decrease * all);
      judged = all;
      objective->DrawViews(out.iterations);
      energies = objective->Evaluate(*V, &half_gradient);
      continue;
    }
    if (finest && accepted && energies.total() > before + kSmallRise * least) {
      // A shorter step slides less.
      V->swap(trial);
      objective->Evaluate(*V, nullptr);
      energies = objective->Assign(*V, &half_gradient);
      damping = std::min(kMostDamping, 10 * std::max(damping, kSlidingDamping));
      out.converged = promised <= least || damping >= kMostDamping;
    } else {
      out.converged = finest && (exhausted || before - energies.total() <= least);
    }
  }
  objective->set_arap_weight(arap_weight);
  if (IsCancelled(cancelled)) return absl::CancelledError("fit: cancelled");
  objective->UseAllViews();
  out.final =
      elsewhere || draws ? objective->Evaluate(*V, nullptr) : objective->Reevaluate(*V, nullptr);
  return out;
}

}  // namespace cagefit
