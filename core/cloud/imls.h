// Signed distance from a point to an oriented cloud by implicit moving least squares
// [oztireli2009].
//
//   f(x) = sum_k n_k.(x - p_k) phi(|x - p_k|) / sum_k phi(|x - p_k|),   phi(r) = (1 - r^2/h^2)^4
//   for r < h, else 0
//
//   grad f = sum_k (phi n_k + (c_k - f) grad phi) / sum_k phi,   c_k = n_k.(x - p_k),
//   grad phi = -8/h^2 (1 - r^2/h^2)^3 (x - p_k)
//
// f is C3 in x where it is defined: phi and its first three derivatives vanish at r = h, so points
// may enter and leave. Vector code, dispatched at run time: results are equal to the bit for one
// instruction set.
#ifndef CAGEFIT_CORE_CLOUD_IMLS_H_
#define CAGEFIT_CORE_CLOUD_IMLS_H_

#include "core/cloud/cell_grid.h"

namespace cagefit {

struct ImlsValue {
  int support = 0;                                     // points within h; 0: nothing else is set
  double value = 0;                                    // f, in the cloud's units, negative inside
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  // dimensionless, exact
  double nearest = 0;                                  // distance to the nearest point
};

// Evaluates f and its gradient at x with radius h > 0. Thread-safe, does not allocate.
ImlsValue EvaluateImls(const CellGrid& grid, const Eigen::Vector3d& x, double h);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_IMLS_H_
