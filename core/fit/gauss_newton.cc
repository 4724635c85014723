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

// One minimisation from *V.
class Descent {
 public:
  Descent(const SolverOptions& options, const CancelFn& cancelled, Objective* objective,
          StepSystem* system, Points3d* V, double first_radius)
      : options_(options),
        cancelled_(cancelled),
        objective_(objective),
        system_(system),
        V_(V),
        arap_weight_(objective->arap_weight()),
        radius_(first_radius),
        stiffness_(options.first_stiffness),
        draws_(objective->images() != nullptr && objective->images()->draws()) {}

  absl::StatusOr<Minimization> Run() {
    absl::Status status = Begin();
    while (status.ok() && out_.iterations < options_.max_iterations && !out_.converged) {
      status = Step();
    }
    objective_->set_arap_weight(arap_weight_);
    if (!status.ok()) return status;
    if (IsCancelled(cancelled_)) return absl::CancelledError("fit: cancelled");
    objective_->UseAllViews();
    out_.final = elsewhere_ || draws_ ? objective_->Evaluate(*V_, nullptr)
                                      : objective_->Reevaluate(*V_, nullptr);
    return out_;
  }

 private:
  absl::Status Begin();
  absl::Status Step();
  void SetCoarseness();
  // Goes on from *V with the next stage's settings, new choices and other views.
  void ChooseAnew(bool accepted, bool exhausted, double decrease, double promised);
  void JudgeByAllViews(bool exhausted);
  void GoBack(double promised, double least);

  const SolverOptions& options_;
  const CancelFn& cancelled_;
  Objective* objective_;
  StepSystem* system_;
  Points3d* V_;
  const double arap_weight_;
  double radius_, stiffness_;  // of the stage: multiples of h and alpha
  const bool draws_;           // some of the views take part at a time

  Minimization out_;
  Points3d half_gradient_, step_, trial_;
  Energies energies_;  // at *V
  double judged_ = 0;  // energy by all views when it was last asked for; 0: never
  double damping_ = kInitialDamping;
  bool stale_ = true;       // the system does not hold the current linearisation
  bool elsewhere_ = false;  // the objective was last evaluated at a trial that was not taken
};

void Descent::SetCoarseness() {
  objective_->set_arap_weight(stiffness_ * arap_weight_);
  objective_->SetCoarseness(radius_, std::max(radius_, std::sqrt(stiffness_)),
                            stiffness_ > kStiffnessFactor || radius_ > 1);
}

absl::Status Descent::Begin() {
  SetCoarseness();
  objective_->UseAllViews();
  objective_->set_arap_weight(arap_weight_);
  out_.initial = out_.final = objective_->Assign(*V_, &half_gradient_);
  if (!std::isfinite(out_.initial.total())) {
    return absl::InternalError(absl::StrFormat("fit: initial energy is %g", out_.initial.total()));
  }
  // Stiff first, so that what moved as a whole is carried as a whole; the details follow. Without
  // this the surface falls straight onto the target and then has to slide along it.
  objective_->set_arap_weight(stiffness_ * arap_weight_);
  objective_->DrawViews(0);
  energies_ = draws_ ? objective_->Evaluate(*V_, &half_gradient_)
                     : objective_->Reevaluate(*V_, &half_gradient_);
  return absl::OkStatus();
}

absl::Status Descent::Step() {
  if (IsCancelled(cancelled_)) return absl::CancelledError("fit: cancelled");
  if (stale_) system_->Linearize(*objective_);
  stale_ = false;
  double promised = 0;
  out_.linear_iterations += system_->Solve(half_gradient_, damping_, kLinearTolerance,
                                           kMaxLinearIterations, cancelled_, &step_, &promised);
  ++out_.iterations;
  if (IsCancelled(cancelled_)) return absl::CancelledError("fit: cancelled");
  if (!step_.allFinite()) return absl::InternalError("fit: diverged, a step is not finite");
  trial_ = *V_ + step_;
  const Energies tried = objective_->Evaluate(trial_, nullptr);
  const double decrease = energies_.total() - tried.total();
  // At rounding level neither energy nor promise means anything any more.
  const bool exhausted = promised <= kRounding * energies_.total() || damping_ >= kMostDamping;
  const bool accepted = decrease >= kLeastGain * promised && promised > 0;
  elsewhere_ = !accepted;
  if (!accepted && !exhausted) {
    damping_ = std::min(kMostDamping, damping_ * 10);
    return absl::OkStatus();
  }
  if (accepted) {
    V_->swap(trial_);
    if (decrease > 0.5 * promised) damping_ = std::max(kLeastDamping, damping_ / 5);
  } else {
    objective_->Evaluate(*V_, &half_gradient_);
    elsewhere_ = false;
  }
  ChooseAnew(accepted, exhausted, decrease, promised);
  return absl::OkStatus();
}

void Descent::ChooseAnew(bool accepted, bool exhausted, double decrease, double promised) {
  // Judged on what is left after new choices: held ones promise more than they keep where feet
  // slide along a curved surface.
  const bool finest = stiffness_ <= 1 && radius_ <= 1;
  const double before = energies_.total(), least = options_.relative_decrease * before;
  stiffness_ = std::max(1.0, stiffness_ / kStiffnessFactor);
  radius_ = std::max(1.0, radius_ / kRadiusFactor);
  SetCoarseness();
  objective_->DrawViews(out_.iterations);
  // Before that the surface is still where it was, and cameras would take its motion for their own.
  if (finest) objective_->Calibrate(*V_);
  energies_ = out_.iterations < kMaxAssignments ? objective_->Assign(*V_, &half_gradient_)
                                                : objective_->AssignFeet(*V_, &half_gradient_);
  stale_ = true;
  if (draws_) {
    // Energies of other views do not compare. Where those of one set end, all are asked.
    if (finest && (exhausted || decrease <= least)) JudgeByAllViews(exhausted);
  } else if (finest && accepted && energies_.total() > before + kSmallRise * least) {
    GoBack(promised, least);
  } else {
    out_.converged = finest && (exhausted || before - energies_.total() <= least);
  }
}

void Descent::JudgeByAllViews(bool exhausted) {
  objective_->UseAllViews();
  const double all = objective_->Evaluate(*V_, nullptr).total();
  out_.converged = exhausted || (judged_ > 0 && judged_ - all <= options_.relative_decrease * all);
  judged_ = all;
  objective_->DrawViews(out_.iterations);
  energies_ = objective_->Evaluate(*V_, &half_gradient_);
}

// A shorter step slides less.
void Descent::GoBack(double promised, double least) {
  V_->swap(trial_);
  objective_->Evaluate(*V_, nullptr);
  energies_ = objective_->Assign(*V_, &half_gradient_);
  damping_ = std::min(kMostDamping, 10 * std::max(damping_, kSlidingDamping));
  out_.converged = promised <= least || damping_ >= kMostDamping;
}

}  // namespace

absl::StatusOr<Minimization> MinimizeGaussNewton(const SolverOptions& options,
                                                 const CancelFn& cancelled, Objective* objective,
                                                 StepSystem* system, Points3d* V,
                                                 double first_radius) {
  return Descent(options, cancelled, objective, system, V, first_radius).Run();
}

}  // namespace cagefit
