// The rotation that best maps one set of vectors to another.
#ifndef CAGEFIT_CORE_ENERGY_ROTATION_H_
#define CAGEFIT_CORE_ENERGY_ROTATION_H_

#include <Eigen/Core>

namespace cagefit {

// The rotation R, det +1, that maximises tr(R^T C), where C = sum_k w_k e_k e'_k^T: it minimises
// sum_k w_k |e_k - R e'_k|^2 [sorkine2007]. Newton's method on SO(3) from `guess` where that
// converges, else the SVD; the result does not depend on the guess beyond rounding.
Eigen::Matrix3d BestRotation(const Eigen::Matrix3d& C, const Eigen::Matrix3d& guess);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_ROTATION_H_
