// How far the samples of the limit surface are from the target.
//
//   E_dist = (n/m) sum_i ( rho( f(Q_i)^2 ) + max(0, d_i - d0)^2 )
//
// n control vertices, m samples, f the signed IMLS or RIMLS distance (cloud/imls.h, rimls.h), d_i
// the distance to the nearest target point, rho a robust kernel (robust_kernel.h). The factor n/m
// gives the term the same weight at any number of samples.
//
// Each sample has a radius and a branch, chosen by Assign and held fixed for value, gradient and
// step acceptance, because f jumps by a percent where a radius doubles:
//   field   the radius h, doubled until at least kMinSupport points lie within it;
//   plane   for samples farther than d0 from every point: f is the signed distance to the nearest
//   point's tangent plane.
// The second residual keeps every sample bound: beside an open border, in the surface's own plane,
// f is 0 in both branches. It knows no kernel: no sample is ever free.
//
// Coarse to fine, h and d0 are multiplied by a common factor.
#ifndef CAGEFIT_CORE_ENERGY_DISTANCE_TERM_H_
#define CAGEFIT_CORE_ENERGY_DISTANCE_TERM_H_

#include <cstdint>
#include <vector>

#include "core/base/types.h"
#include "core/cloud/imls.h"
#include "core/cloud/rimls.h"
#include "core/cloud/target_index.h"
#include "core/energy/field.h"
#include "core/energy/robust_kernel.h"

namespace cagefit {

// Residuals of one sample and their exact gradients at held radius and branch.
struct SampleResiduals {
  double f = 0;       // signed distance, unit coordinates
  double weight = 1;  // rho'(f^2)
  double beyond = 0;  // max(0, d - d0)
  Eigen::Vector3d grad_f = Eigen::Vector3d::Zero();
  Eigen::Vector3d grad_beyond = Eigen::Vector3d::Zero();
  int support = 0;  // points within the held radius; 0 in the plane branch
};

// Not thread-safe but for EvaluateSample. Buffers keep their capacity.
class DistanceTerm {
 public:
  static constexpr int kMinSupport = 8;

  // Refers to `target`, which must outlive the term. Lengths in the target's coordinates. n control
  // vertices. The energy is multiplied by `term_weight`; 0: residuals are 0 and nothing is looked
  // at.
  void SetTarget(const TargetIndex* target, double far_radius, int64_t control_vertices,
                 Field field = Field::kImls, const RobustKernel& kernel = {},
                 double term_weight = 1);

  // Multiplies h and d0 of the target by `factor` >= 1 from the next Assign on, whose `residuals`
  // must be empty where the factor changed, and the kernel's scale by `kernel_factor`.
  void SetCoarseness(double factor, double kernel_factor);

  // Chooses radius and branch of every sample at Q (3 x m), updates the residuals to them and
  // returns the energy. `residuals` is empty, or what Evaluate gave at the same Q: then samples
  // that need no other radius are left alone.
  double Assign(const Points3d& Q, std::vector<SampleResiduals>* residuals);

  // Energy at Q; writes the residuals of all m samples. Radius and branch are those of the last
  // Assign.
  double Evaluate(const Points3d& Q, std::vector<SampleResiduals>* residuals) const;

  // Residuals of sample i at x.
  SampleResiduals EvaluateSample(int64_t i, const Eigen::Vector3d& x) const;

  double weight() const { return weight_; }  // n/m, times that of the term
  const RobustKernel& kernel() const { return scaled_kernel_; }
  int64_t grown_samples() const;  // radius doubled at least once
  int64_t far_samples() const;    // in the plane branch

 private:
  static constexpr int8_t kFar = -1;
  static constexpr int8_t kUnassigned = -2;
  static constexpr int kMaxDoublings = 20;

  struct Assignment {
    int8_t doublings = kUnassigned;  // radius h 2^doublings; kFar: plane branch
    int32_t nearest = -1;            // plane branch: index of the nearest point
    RimlsReference reference;        // field branch, with Field::kRimls: held like the radius
  };

  // Chooses radius and branch for a sample at x; returns its residuals under them.
  SampleResiduals AssignSample(const Eigen::Vector3d& x, Assignment* assignment) const;
  ImlsValue EvaluateField(const Eigen::Vector3d& x, double h, const Assignment& assignment) const;
  SampleResiduals FromField(const ImlsValue& field, const Eigen::Vector3d& x) const;
  SampleResiduals EvaluatePlane(int32_t nearest, const Eigen::Vector3d& x) const;

  double Energy(SampleResiduals* residuals) const;  // writes the weight

  const TargetIndex* target_ = nullptr;
  double radius_ = 0, far_radius_ = 0, finest_far_radius_ = 0;
  Field field_ = Field::kImls;
  RobustKernel kernel_, scaled_kernel_;
  int64_t control_vertices_ = 0;
  double term_weight_ = 1, weight_ = 0;
  std::vector<Assignment> assignments_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_DISTANCE_TERM_H_
