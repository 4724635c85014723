#include "core/fit/objective.h"

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 8192;  // control vertices a chunk

bool AreEqual(const StencilMatrix& a, const StencilMatrix& b) {
  return a.rows() == b.rows() && a.nonZeros() == b.nonZeros() &&
         std::equal(a.valuePtr(), a.valuePtr() + a.nonZeros(), b.valuePtr()) &&
         std::equal(a.innerIndexPtr(), a.innerIndexPtr() + a.nonZeros(), b.innerIndexPtr());
}

StencilMatrix Stack(const StencilMatrix& top, const StencilMatrix& bottom) {
  StencilMatrix out(top.rows() + bottom.rows(), top.cols());
  out.resizeNonZeros(top.nonZeros() + bottom.nonZeros());
  int64_t at = 0, row = 0;
  for (const StencilMatrix* part : {&top, &bottom}) {
    for (int64_t i = 0; i < part->rows(); ++i) {
      out.outerIndexPtr()[row++] = static_cast<int32_t>(at) + part->outerIndexPtr()[i];
    }
    std::copy(part->valuePtr(), part->valuePtr() + part->nonZeros(), out.valuePtr() + at);
    std::copy(part->innerIndexPtr(), part->innerIndexPtr() + part->nonZeros(),
              out.innerIndexPtr() + at);
    at += part->nonZeros();
  }
  out.outerIndexPtr()[row] = static_cast<int32_t>(at);
  return out;
}

}  // namespace

Objective::Objective(const Topology& topology, StencilMatrix S, double arap_weight,
                     OptionalTerms terms)
    : S_(std::move(S)),
      St_(S_.transpose()),
      arap_weight_(arap_weight),
      arap_(topology),
      terms_(std::move(terms)),
      surface_(terms_.coverage != nullptr ? terms_.coverage->m1()
               : terms_.images != nullptr ? terms_.images->m1()
                                          : nullptr) {
  if (surface_ == nullptr || AreEqual(S_, surface_->position)) return;
  stacked_ = Stack(S_, surface_->position);
  surface_begin_ = S_.rows();
}

void Objective::SetTarget(const ObjectiveTarget& target) {
  distance_.SetTarget(target.index, target.far_radius, S_.cols(), target.field, target.kernel,
                      target.distance_weight);
  if (terms_.coverage != nullptr) {
    terms_.coverage->SetTarget(target.covered,
                               target.covered != nullptr ? target.covered->size() : 0,
                               target.coverage_weight, target.kernel);
  }
  if (terms_.images != nullptr)
    terms_.images->SetTarget(target.images, target.image_weights, target.frame);
  if (terms_.landmarks != nullptr) {
    terms_.landmarks->SetTarget(target.landmarks, target.landmark_weight);
  }
  if (terms_.boundary != nullptr) {
    terms_.boundary->SetTarget(target.boundary, target.boundary_weight);
  }
  radius_factor_ = 1;
  residuals_.clear();
}

absl::InlinedVector<const Attachments*, 2> Objective::attachments() const {
  absl::InlinedVector<const Attachments*, 2> all;
  if (terms_.landmarks != nullptr) all.push_back(&terms_.landmarks->attachments());
  if (terms_.boundary != nullptr) all.push_back(&terms_.boundary->attachments());
  return all;
}

bool Objective::has_feet() const {
  return (terms_.coverage != nullptr && terms_.coverage->is_on()) ||
         (terms_.boundary != nullptr && terms_.boundary->is_on());
}

void Objective::DrawViews(int64_t iteration) {
  if (terms_.images != nullptr) terms_.images->Draw(iteration);
}

void Objective::UseAllViews() {
  if (terms_.images != nullptr) terms_.images->UseAll();
}

bool Objective::SurfaceBlocksOf(SurfaceBlocks* blocks) const {
  const bool covers = terms_.coverage != nullptr && terms_.coverage->is_on();
  const bool shows = terms_.images != nullptr && terms_.images->is_on();
  if (!covers && !shows) return false;
  blocks->SetZero(surface_->topology);
  if (covers) terms_.coverage->AddBlocks(blocks);
  if (shows) terms_.images->AddBlocks(blocks);
  return true;
}

void Objective::SetCoarseness(double radius_factor, double kernel_factor, bool is_coarse) {
  distance_.SetCoarseness(radius_factor, kernel_factor);
  if (terms_.coverage != nullptr) terms_.coverage->SetCoarseness(kernel_factor, is_coarse);
  if (radius_factor != radius_factor_) residuals_.clear();
  radius_factor_ = radius_factor;
}

void Objective::ChooseFeet(const Points3d& V) {
  coverage_energy_ = terms_.coverage != nullptr ? terms_.coverage->Assign(V) : 0;
  image_energy_ = terms_.images != nullptr ? terms_.images->Evaluate(V) : 0;
  if (terms_.boundary != nullptr) terms_.boundary->Assign(V);
}

void Objective::EvaluateTerms(const Points3d& V) {
  coverage_energy_ = terms_.coverage != nullptr ? terms_.coverage->Evaluate(V) : 0;
  image_energy_ = terms_.images != nullptr ? terms_.images->Evaluate(V) : 0;
}

Energies Objective::Assign(const Points3d& V, Points3d* half_gradient) {
  ApplyStencils(S_, V, &Q_);
  distance_energy_ = distance_.Assign(Q_, &residuals_);
  ChooseFeet(V);
  return Reevaluate(V, half_gradient);
}

Energies Objective::AssignSamples(const Points3d& V, Points3d* half_gradient) {
  ApplyStencils(S_, V, &Q_);
  residuals_.clear();
  distance_energy_ = distance_.Assign(Q_, &residuals_);
  EvaluateTerms(V);
  return Reevaluate(V, half_gradient);
}

Energies Objective::AssignFeet(const Points3d& V, Points3d* half_gradient) {
  ApplyStencils(S_, V, &Q_);
  distance_energy_ = distance_.Evaluate(Q_, &residuals_);
  ChooseFeet(V);
  return Reevaluate(V, half_gradient);
}

Energies Objective::Evaluate(const Points3d& V, Points3d* half_gradient) {
  ApplyStencils(S_, V, &Q_);
  distance_energy_ = distance_.Evaluate(Q_, &residuals_);
  EvaluateTerms(V);
  return Reevaluate(V, half_gradient);
}

Energies Objective::Reevaluate(const Points3d& V, Points3d* half_gradient) {
  Energies energies;
  energies.distance = distance_energy_;
  energies.coverage = coverage_energy_;
  energies.image = image_energy_;
  if (terms_.landmarks != nullptr) energies.landmarks = terms_.landmarks->attachments().Energy(V);
  if (terms_.boundary != nullptr) energies.boundary = terms_.boundary->attachments().Energy(V);
  if (arap_weight_ > 0) {
    arap_.UpdateRotations(V);
    energies.arap = arap_weight_ * arap_.Evaluate(V, half_gradient);
  }
  if (half_gradient == nullptr) return energies;
  if (arap_weight_ > 0) {
    *half_gradient *= arap_weight_;
  } else {
    half_gradient->setZero(3, V.cols());
  }
  // dE_dist/dV_j = 2 n/m sum_i S_ij (rho' f grad f + beyond grad beyond).
  const double weight = distance_.weight();
  ParallelFor(V.cols(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t j = begin; j < end; ++j) {
      Eigen::Vector3d g = Eigen::Vector3d::Zero();
      for (StencilMatrix::InnerIterator s(St_, j); s; ++s) {
        const SampleResiduals& r = residuals_[s.col()];
        g += s.value() * (r.weight * r.f * r.grad_f + r.beyond * r.grad_beyond);
      }
      half_gradient->col(j) += weight * g;
    }
  });
  if (terms_.coverage != nullptr) terms_.coverage->AddHalfGradient(half_gradient);
  if (terms_.images != nullptr) terms_.images->AddHalfGradient(half_gradient);
  for (const Attachments* set : attachments()) set->AddHalfGradient(V, half_gradient);
  return energies;
}

}  // namespace cagefit
