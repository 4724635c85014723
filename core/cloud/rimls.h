// Signed distance that keeps edges: robust implicit moving least squares [oztireli2009].
//
//   f(x) = sum_k W_k c_k / sum_k W_k,   c_k = n_k.(x - p_k),   W_k = phi(|x - p_k|) e_k
//   e_k  = exp(-(c_k - f0)^2 / sigma_r^2) exp(-|n_k - g0|^2 / sigma_n^2),   sigma_r = 0.5 h
//
// phi and h as in cloud/imls.h. Points whose plane or normal does not fit the reference (f0, g0),
// value and gradient of f at x, count less: those round an edge, and outliers. The reference is
// found by fixed-point iteration from IMLS and then held fixed, as the radius is, so that f is an
// exact, smooth function of x near the place of its reference:
//
//   grad f = sum_k (W_k n_k + (c_k - f) (e_k grad phi - 2 (c_k - f0) / sigma_r^2 W_k n_k)) / sum
//   W_k
#ifndef CAGEFIT_CORE_CLOUD_RIMLS_H_
#define CAGEFIT_CORE_CLOUD_RIMLS_H_

#include "core/cloud/imls.h"

namespace cagefit {

struct RimlsOptions {
  double normal_sigma = 0.8;  // sigma_n: 0.5 (sharp edges) to 1.5 (nearly IMLS)
  int rounds = 3;             // of the fixed-point iteration, 1 or more
};

struct RimlsReference {
  double value = 0;                                    // f0, in the cloud's units
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();  // g0, no longer than 1
};

// The reference of x: from IMLS, `rounds` times f and its gradient (W held) under the last one. All
// zero where there is no point within h. Thread-safe, does not allocate.
RimlsReference SolveRimls(const CellGrid& grid, const Eigen::Vector3d& x, double h,
                          const RimlsOptions& options);

// Evaluates f and its gradient at x with radius h > 0 under the reference. Thread-safe, does not
// allocate. Equal to the bit for one instruction set.
ImlsValue EvaluateRimls(const CellGrid& grid, const Eigen::Vector3d& x, double h,
                        const RimlsOptions& options, const RimlsReference& reference);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_RIMLS_H_
