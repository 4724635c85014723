#include "core/energy/robust_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace cagefit {
namespace {

constexpr Kernel kKernels[] = {Kernel::kIdentity, Kernel::kHuber, Kernel::kGemanMcClure,
                               Kernel::kTukey};
constexpr double kScales[] = {0.01, 1, 30};

// Residuals from far below the scale to far above it.
std::vector<double> Residuals(double scale) {
  std::vector<double> residuals;
  for (double r = 1e-3; r < 1e3; r *= 1.13) residuals.push_back(scale * r);
  return residuals;
}

double Weight(const RobustKernel& kernel, double s) {
  double weight = 0;
  kernel.Rho(s, &weight);
  return weight;
}

// Twice the loss of r = u c, with psi(r) ~ r near 0, as textbooks give it for c.
double Textbook(Kernel kernel, double r, double c) {
  const double u = r / c;
  switch (kernel) {
    case Kernel::kHuber:
      return 2 * (u <= 1 ? r * r / 2 : c * (r - c / 2));
    case Kernel::kGemanMcClure:
      return r * r * c * c / (c * c + r * r);
    case Kernel::kTukey:
      return 2 * (u <= 1 ? c * c / 6 * (1 - std::pow(1 - u * u, 3)) : c * c / 6);
    default:
      return r * r;
  }
}

TEST(RobustKernelTest, EqualsTheTextbook) {
  for (const Kernel kernel : kKernels) {
    for (const double c : kScales) {
      for (const double r : Residuals(c)) {
        const double expected = Textbook(kernel, r, c);
        // Tukey's 1 - (1 - u^2)^3 loses what u^2 lacks to 1.
        EXPECT_NEAR((RobustKernel{kernel, c}.Rho(r * r, nullptr)), expected,
                    1e-12 * expected + 1e-15 * c * c)
            << "kernel " << static_cast<int>(kernel) << ", residual " << r / c << " c";
      }
    }
  }
}

TEST(RobustKernelTest, WeightIsTheSlope) {
  for (const Kernel kernel : kKernels) {
    for (const double c : kScales) {
      const RobustKernel rho{kernel, c};
      for (const double r : Residuals(c)) {
        const double s = r * r, step = std::max(1e-5 * s, std::min(s, 1e-5 * c * c));
        const double difference =
            (rho.Rho(s + step, nullptr) - rho.Rho(s - step, nullptr)) / (2 * step);
        EXPECT_NEAR(Weight(rho, s), difference, 1e-6)
            << "kernel " << static_cast<int>(kernel) << ", residual " << r / c << " c";
      }
    }
  }
}

TEST(RobustKernelTest, WeightIsContinuousAtTheScale) {
  for (const Kernel kernel : kKernels) {
    const RobustKernel rho{kernel, 0.3};
    const double s = 0.3 * 0.3;
    EXPECT_NEAR(rho.Rho(s * (1 - 1e-9), nullptr), rho.Rho(s * (1 + 1e-9), nullptr), 3e-9 * s);
    EXPECT_NEAR(Weight(rho, s * (1 - 1e-9)), Weight(rho, s * (1 + 1e-9)), 1e-8);
  }
}

TEST(RobustKernelTest, SmallResidualsCountInFull) {
  for (const Kernel kernel : kKernels) {
    for (const double c : kScales) {
      const RobustKernel rho{kernel, c};
      for (const double share : {0.0, 1e-8, 1e-5, 1e-3}) {
        const double s = share * c * c;
        EXPECT_NEAR(rho.Rho(s, nullptr), s, 2 * share * s + 1e-15 * c * c);
        EXPECT_NEAR(Weight(rho, s), 1, 2 * share + 1e-15);
      }
    }
  }
}

TEST(RobustKernelTest, GrowsWithTheResidualButNoFasterThanItsSquare) {
  for (const Kernel kernel : kKernels) {
    const RobustKernel rho{kernel, 0.5};
    double before = 0, weight_before = 1;
    for (const double r : Residuals(0.5)) {
      double weight = 0;
      const double value = rho.Rho(r * r, &weight);
      EXPECT_GE(value, before);
      EXPECT_LE(value, r * r * (1 + 1e-9));
      EXPECT_GE(weight, 0);
      EXPECT_LE(weight, weight_before * (1 + 1e-12));
      before = value;
      weight_before = weight;
    }
  }
}

TEST(RobustKernelTest, RedescendingKernelsAreBounded) {
  const double c = 0.2;
  const RobustKernel geman{Kernel::kGemanMcClure, c}, tukey{Kernel::kTukey, c};
  EXPECT_NEAR(geman.Rho(1e12, nullptr), c * c, 1e-12);
  EXPECT_NEAR(Weight(geman, 1e12), 0, 1e-12);
  for (const double r : {1.0 * c, 1.1 * c, 1e6 * c}) {
    EXPECT_DOUBLE_EQ(tukey.Rho(r * r, nullptr), c * c / 3);
    EXPECT_EQ(Weight(tukey, r * r), 0);
  }
}

TEST(RobustKernelTest, HuberGrowsLikeTheResidual) {
  const RobustKernel huber{Kernel::kHuber, 0.2};
  EXPECT_NEAR(huber.Rho(4e6, nullptr) - huber.Rho(1e6, nullptr), 2 * 0.2 * (2000 - 1000), 1e-9);
}

TEST(RobustKernelTest, StaysFiniteAtHugeResiduals) {
  for (const Kernel kernel : kKernels) {
    double weight = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(std::isfinite((RobustKernel{kernel, 1e-6}.Rho(1e30, &weight))));
    EXPECT_TRUE(std::isfinite(weight));
  }
}

}  // namespace
}  // namespace cagefit
