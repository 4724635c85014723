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
                     std::unique_ptr<CoverageTerm> coverage, std::unique_ptr<ImageTerm> images)
    : S_(std::move(S)),
      St_(S_.transpose()),
      arap_weight_(arap_weight),
      arap_(topology),
      coverage_(std::move(coverage)),
      images_(std::move(images)),
      surface_(coverage_ != nullptr ? coverage_->m1()
               : images_ != nullptr ? images_->m1()
                                    : nullptr) {
  if (surface_ == nullptr || AreEqual(S_, surface_->position)) return;
  stacked_ = Stack(S_, surface_->position);
  surface_begin_ = S_.rows();
}

void Objective::SetTarget(const ObjectiveTarget& target) {
  distance_.SetTarget(target.index, target.far_radius, S_.cols(), target.field, target.kernel,
                      target.distance_weight);
  if (coverage_ != nullptr) {
    coverage_->SetTarget(target.covered, target.covered != nullptr ? target.covered->size() : 0,
                         target.coverage_weight, target.kernel);
  }
  if (images_ != nullptr) images_->SetTarget(target.images, target.image_weights, target.frame);
  radius_factor_ = 1;
  residuals_.clear();
}

void Objective::DrawViews(int64_t iteration) {
  if (images_ != nullptr) images_->Draw(iteration);
}

void Objective::UseAllViews() {
  if (images_ != nullptr) images_->UseAll();
}

bool Objective::SurfaceBlocksOf(SurfaceBlocks* blocks) const {
  const bool covers = coverage_ != nullptr && coverage_->is_on();
  const bool shows = images_ != nullptr && images_->is_on();
  if (!covers && !shows) return false;
  blocks->SetZero(surface_->topology);
  if (covers) coverage_->AddBlocks(blocks);
  if (shows) images_->AddBlocks(blocks);
  return true;
}

void Objective::SetCoarseness(double radius_factor, double kernel_factor, bool is_coarse) {
  distance_.SetCoarseness(radius_factor, kernel_factor);
  if (coverage_ != nullptr) coverage_->SetCoarseness(kernel_factor, is_coarse);
  if (radius_factor != radius_factor_) residuals_.clear();
  radius_factor_ = radius_factor;
}

Energies Objective::Assign(const Points3d& V, Points3d* half_gradient) {
  ApplyStencils(S_, V, &Q_);
  distance_energy_ = distance_.Assign(Q_, &residuals_);
  coverage_energy_ = coverage_ != nullptr ? coverage_->Assign(V) : 0;
  image_energy_ = images_ != nullptr ? images_->Evaluate(V) : 0;
  return Reevaluate(V, half_gradient);
}

Energies Objective::AssignSamples(const Points3d& V, Points3d* half_gradient) {
  ApplyStencils(S_, V, &Q_);
  residuals_.clear();
  distance_energy_ = distance_.Assign(Q_, &residuals_);
  coverage_energy_ = coverage_ != nullptr ? coverage_->Evaluate(V) : 0;
  image_energy_ = images_ != nullptr ? images_->Evaluate(V) : 0;
  return Reevaluate(V, half_gradient);
}

Energies Objective::AssignFeet(const Points3d& V, Points3d* half_gradient) {
  ApplyStencils(S_, V, &Q_);
  distance_energy_ = distance_.Evaluate(Q_, &residuals_);
  coverage_energy_ = coverage_ != nullptr ? coverage_->Assign(V) : 0;
  image_energy_ = images_ != nullptr ? images_->Evaluate(V) : 0;
  return Reevaluate(V, half_gradient);
}

Energies Objective::Evaluate(const Points3d& V, Points3d* half_gradient) {
  ApplyStencils(S_, V, &Q_);
  distance_energy_ = distance_.Evaluate(Q_, &residuals_);
  coverage_energy_ = coverage_ != nullptr ? coverage_->Evaluate(V) : 0;
  image_energy_ = images_ != nullptr ? images_->Evaluate(V) : 0;
  return Reevaluate(V, half_gradient);
}

Energies Objective::Reevaluate(const Points3d& V, Points3d* half_gradient) {
  Energies energies;
  energies.distance = distance_energy_;
  energies.coverage = coverage_energy_;
  energies.image = image_energy_;
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
  if (coverage_ != nullptr) coverage_->AddHalfGradient(half_gradient);
  if (images_ != nullptr) images_->AddHalfGradient(half_gradient);
  return energies;
}

}  // namespace cagefit
