// Points of the surface that are drawn to points of space:
//
//   E = sum_k r_k^T A_k r_k,   r_k = S_k V - p_k
//
// S_k a row over the control vertices, p_k a point, A_k symmetric and positive semidefinite, 0 for
// a row that takes no part. What landmarks and boundaries become for every solver.
#ifndef CAGEFIT_CORE_ENERGY_ATTACHMENTS_H_
#define CAGEFIT_CORE_ENERGY_ATTACHMENTS_H_

#include <Eigen/Core>
#include <vector>

#include "core/base/types.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

struct Attachments {
  StencilMatrix rows;                    // K x n; may have no rows and then any number of columns
  Points3d targets;                      // 3 x K
  std::vector<Eigen::Matrix3d> weights;  // A_k

  int64_t size() const { return rows.rows(); }
  void Clear() { rows.resize(0, 0); }

  // At V (3 x n).
  double Energy(const Points3d& V) const;
  // Adds half the gradient, sum_k S_k^T A_k r_k (3 x n).
  void AddHalfGradient(const Points3d& V, Points3d* half_gradient) const;

 private:
  Eigen::Vector3d Residual(int64_t k, const Points3d& V) const;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_ATTACHMENTS_H_
