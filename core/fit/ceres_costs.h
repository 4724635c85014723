// The terms of the energy as Ceres cost functions: 1/2 |residuals|^2 summed over all of them is
// half the energy.
#ifndef CAGEFIT_CORE_FIT_CERES_COSTS_H_
#define CAGEFIT_CORE_FIT_CERES_COSTS_H_

#include <ceres/cost_function.h>

#include <cstdint>
#include <vector>

#include "core/energy/arap_term.h"
#include "core/energy/coverage_term.h"
#include "core/energy/distance_term.h"

namespace cagefit {

// sqrt(n/m) (+-sqrt(rho(f^2)), beyond) of sample i. Parameter blocks: the control vertices of its
// stencil.
class SampleCost : public ceres::CostFunction {
 public:
  SampleCost(const DistanceTerm& distance, int64_t sample, std::vector<double> stencil);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const DistanceTerm& distance_;
  int64_t sample_;
  std::vector<double> stencil_;
};

// sqrt(gamma n/K) times +-sqrt(rho) of the residual of one covered point. Parameter blocks: the
// control vertices of `stencil`, the row of the point's foot over them.
class CoverageCost : public ceres::CostFunction {
 public:
  CoverageCost(const CoverageTerm::Row& row, const RobustKernel& kernel,
               std::vector<double> stencil);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  CoverageTerm::Row row_;
  RobustKernel kernel_;
  std::vector<double> stencil_;
};

// The symmetric square root of `weight` times S V - target, of one attachment. Parameter blocks:
// the control vertices of `stencil`, the entries of S.
class AttachmentCost : public ceres::CostFunction {
 public:
  AttachmentCost(const Eigen::Matrix3d& weight, const Eigen::Vector3d& target,
                 std::vector<double> stencil);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Matrix3d root_;
  Eigen::Vector3d target_;
  std::vector<double> stencil_;
};

// sqrt(alpha w_ij) ((V_i - V_j) - R_i (V'_i - V'_j)) for all neighbours j of i, R_i the best
// rotation. Parameter blocks: V_i, then its neighbours. The Jacobian lets R_i follow to first
// order, as in energy/arap_term.h.
class ArapCost : public ceres::CostFunction {
 public:
  ArapCost(const ArapTerm& arap, int32_t vertex, double alpha);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const ArapTerm& arap_;
  int32_t vertex_;
  double alpha_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_CERES_COSTS_H_
