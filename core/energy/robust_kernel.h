// Robust kernels: how much a residual counts.
//
//   identity       rho(s) = s
//   Huber          rho(s) = s for s <= c^2, else 2 c sqrt(s) - c^2
//   Geman-McClure  rho(s) = s / (1 + s/c^2)
//   Tukey          rho(s) = c^2/3 (1 - (1 - s/c^2)^3) for s <= c^2, else c^2/3
//
// s is a squared residual, c the scale, in the residual's units. rho(s) = s + O(s^2) near 0, so
// that weights of terms keep their meaning, and Tukey's stops at c. Sources: [huber1964],
// [geman1985], [beaton1974].
#ifndef CAGEFIT_CORE_ENERGY_ROBUST_KERNEL_H_
#define CAGEFIT_CORE_ENERGY_ROBUST_KERNEL_H_

#include <cmath>

namespace cagefit {

enum class Kernel { kIdentity, kHuber, kGemanMcClure, kTukey };

struct RobustKernel {
  Kernel kernel = Kernel::kIdentity;
  double scale = 1;  // c > 0

  // rho(s), s >= 0. Writes rho'(s), in [0, 1], when `weight` is not null: the gradient of
  // rho(r^2) is 2 rho' r grad r, and the Gauss-Newton matrix is that of the residual weighted by
  // rho' (iteratively reweighted least squares).
  double Rho(double s, double* weight) const {
    double value = s, slope = 1;
    const double c2 = scale * scale;
    switch (kernel) {
      case Kernel::kIdentity:
        break;
      case Kernel::kHuber:
        if (s > c2) {
          const double r = std::sqrt(s);
          value = 2 * scale * r - c2;
          slope = scale / r;
        }
        break;
      case Kernel::kGemanMcClure: {
        const double q = 1 / (1 + s / c2);
        value = s * q;
        slope = q * q;
        break;
      }
      case Kernel::kTukey: {
        const double q = s < c2 ? 1 - s / c2 : 0;
        value = c2 / 3 * (1 - q * q * q);
        slope = q * q;
        break;
      }
    }
    if (weight != nullptr) *weight = slope;
    return value;
  }
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_ROBUST_KERNEL_H_
