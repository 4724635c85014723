#include "core/energy/distance_term.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 512;  // samples a chunk: some 0.2 ms

}  // namespace

void DistanceTerm::SetTarget(const TargetIndex* target, double far_radius, int64_t control_vertices,
                             Field field, const RobustKernel& kernel, double term_weight) {
  term_weight_ = term_weight;
  field_ = field;
  target_ = target;
  radius_ = target->radius();
  far_radius_ = finest_far_radius_ = far_radius;
  kernel_ = scaled_kernel_ = kernel;
  control_vertices_ = control_vertices;
  assignments_.clear();
}

void DistanceTerm::SetCoarseness(double factor, double kernel_factor) {
  radius_ = factor * target_->radius();
  far_radius_ = factor * finest_far_radius_;
  scaled_kernel_.scale = kernel_.scale * kernel_factor;
}

double DistanceTerm::Energy(SampleResiduals* r) const {
  return scaled_kernel_.Rho(r->f * r->f, &r->weight) + r->beyond * r->beyond;
}

double DistanceTerm::Assign(const Points3d& Q, std::vector<SampleResiduals>* residuals) {
  const bool evaluated = static_cast<int64_t>(residuals->size()) == Q.cols() &&
                         static_cast<int64_t>(assignments_.size()) == Q.cols();
  weight_ = term_weight_ * static_cast<double>(control_vertices_) / static_cast<double>(Q.cols());
  if (term_weight_ == 0) {
    residuals->assign(Q.cols(), SampleResiduals());
    return 0;
  }
  assignments_.resize(Q.cols());
  residuals->resize(Q.cols());
  return weight_ * ParallelSum(Q.cols(), kGrain, [&](int64_t begin, int64_t end) {
           double sum = 0;
           for (int64_t i = begin; i < end; ++i) {
             SampleResiduals& r = (*residuals)[i];
             const bool settled = evaluated && field_ == Field::kImls &&
                                  assignments_[i].doublings == 0 && r.support >= kMinSupport &&
                                  r.beyond == 0;
             if (!settled) r = AssignSample(Q.col(i), &assignments_[i]);
             sum += Energy(&r);
           }
           return sum;
         });
}

SampleResiduals DistanceTerm::AssignSample(const Eigen::Vector3d& x, Assignment* assignment) const {
  double h = radius_;
  for (int doublings = 0; doublings <= kMaxDoublings; ++doublings, h *= 2) {
    const ImlsValue field = EvaluateImls(target_->grid(), x, h);
    if (field.support > 0 && field.nearest > far_radius_) break;
    if (field.support >= kMinSupport) {
      *assignment = {static_cast<int8_t>(doublings), -1, {}};
      if (field_ == Field::kImls) return FromField(field, x);
      assignment->reference = SolveRimls(target_->grid(), x, h, RimlsOptions());
      return FromField(EvaluateField(x, h, *assignment), x);
    }
    if (field.support == 0 && h >= far_radius_) break;
  }
  *assignment = {kFar, target_->Nearest(x), {}};
  return EvaluatePlane(assignment->nearest, x);
}

double DistanceTerm::Evaluate(const Points3d& Q, std::vector<SampleResiduals>* residuals) const {
  if (term_weight_ == 0) {
    residuals->assign(Q.cols(), SampleResiduals());
    return 0;
  }
  residuals->resize(Q.cols());
  return weight_ * ParallelSum(Q.cols(), kGrain, [&](int64_t begin, int64_t end) {
           double sum = 0;
           for (int64_t i = begin; i < end; ++i) {
             SampleResiduals& r = (*residuals)[i];
             r = EvaluateSample(i, Q.col(i));
             sum += Energy(&r);
           }
           return sum;
         });
}

SampleResiduals DistanceTerm::EvaluateSample(int64_t i, const Eigen::Vector3d& x) const {
  const Assignment& assignment = assignments_[i];
  if (assignment.doublings == kFar) return EvaluatePlane(assignment.nearest, x);
  const double h = std::ldexp(radius_, assignment.doublings);
  const ImlsValue field = EvaluateField(x, h, assignment);
  // A trial step may leave the support that the radius was chosen for.
  if (field.support == 0) return EvaluatePlane(target_->Nearest(x), x);
  return FromField(field, x);
}

ImlsValue DistanceTerm::EvaluateField(const Eigen::Vector3d& x, double h,
                                      const Assignment& assignment) const {
  if (field_ == Field::kImls) return EvaluateImls(target_->grid(), x, h);
  return EvaluateRimls(target_->grid(), x, h, RimlsOptions(), assignment.reference);
}

SampleResiduals DistanceTerm::FromField(const ImlsValue& field, const Eigen::Vector3d& x) const {
  SampleResiduals out;
  out.support = field.support;
  out.f = field.value;
  out.grad_f = field.gradient;
  if (field.nearest > far_radius_) {
    const Eigen::Vector3d offset = x - target_->point(target_->Nearest(x));
    const double distance = offset.norm();
    out.beyond = std::max(0.0, distance - far_radius_);
    if (out.beyond > 0) out.grad_beyond = offset / distance;
  }
  return out;
}

SampleResiduals DistanceTerm::EvaluatePlane(int32_t nearest, const Eigen::Vector3d& x) const {
  const Eigen::Vector3d offset = x - target_->point(nearest);
  SampleResiduals out;
  out.grad_f = target_->normal(nearest);
  out.f = out.grad_f.dot(offset);
  const double distance = offset.norm();
  if (distance > far_radius_) {
    out.beyond = distance - far_radius_;
    out.grad_beyond = offset / distance;
  }
  return out;
}

int64_t DistanceTerm::grown_samples() const {
  return std::count_if(assignments_.begin(), assignments_.end(),
                       [](const Assignment& a) { return a.doublings > 0; });
}

int64_t DistanceTerm::far_samples() const {
  return std::count_if(assignments_.begin(), assignments_.end(),
                       [](const Assignment& a) { return a.doublings == kFar; });
}

}  // namespace cagefit
