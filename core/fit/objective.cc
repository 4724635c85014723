#include "core/fit/objective.h"

#include <utility>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 8192;  // control vertices a chunk

}  // namespace

Objective::Objective(const Topology& topology, StencilMatrix S, double arap_weight)
    : S_(std::move(S)), St_(S_.transpose()), arap_weight_(arap_weight), arap_(topology) {}

void Objective::SetTarget(const TargetIndex* target, double far_radius) {
  distance_.SetTarget(target, far_radius, S_.cols());
  residuals_.clear();
}

Energies Objective::Assign(const Points3d& V, Points3d* half_gradient) {
  ApplyStencils(S_, V, &Q_);
  distance_energy_ = distance_.Assign(Q_, &residuals_);
  return Reevaluate(V, half_gradient);
}

Energies Objective::Evaluate(const Points3d& V, Points3d* half_gradient) {
  ApplyStencils(S_, V, &Q_);
  distance_energy_ = distance_.Evaluate(Q_, &residuals_);
  return Reevaluate(V, half_gradient);
}

Energies Objective::Reevaluate(const Points3d& V, Points3d* half_gradient) {
  Energies energies;
  energies.distance = distance_energy_;
  half_gradient->resize(3, V.cols());
  half_gradient->setZero();
  if (arap_weight_ > 0) {
    arap_.UpdateRotations(V);
    energies.arap = arap_weight_ * arap_.Evaluate(V, half_gradient);
    *half_gradient *= arap_weight_;
  }
  // dE_dist/dV_j = 2 n/m sum_i S_ij (f grad f + beyond grad beyond).
  const double weight = distance_.weight();
  ParallelFor(V.cols(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t j = begin; j < end; ++j) {
      Eigen::Vector3d g = Eigen::Vector3d::Zero();
      for (StencilMatrix::InnerIterator s(St_, j); s; ++s) {
        const SampleResiduals& r = residuals_[s.col()];
        g += s.value() * (r.f * r.grad_f + r.beyond * r.grad_beyond);
      }
      half_gradient->col(j) += weight * g;
    }
  });
  return energies;
}

}  // namespace cagefit
