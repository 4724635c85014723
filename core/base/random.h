// Seeded random numbers that are the same with every standard library.
#ifndef CAGEFIT_CORE_BASE_RANDOM_H_
#define CAGEFIT_CORE_BASE_RANDOM_H_

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <random>

namespace cagefit {

class Random {
 public:
  explicit Random(uint64_t seed) : engine_(seed) {}

  // Uniform in [0, 1).
  double Uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  // Standard normal (Box-Muller).
  double Normal() {
    constexpr double kTwoPi = 6.283185307179586;
    const double u = Uniform(), v = Uniform();
    return std::sqrt(-2 * std::log(1 - u)) * std::cos(kTwoPi * v);
  }
  // The vectors' coordinates are drawn in their order, whatever the compiler.
  Eigen::Vector3d UniformVector() {
    const double x = Uniform(), y = Uniform(), z = Uniform();
    return {x, y, z};
  }
  Eigen::Vector3d NormalVector() {
    const double x = Normal(), y = Normal(), z = Normal();
    return {x, y, z};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_BASE_RANDOM_H_
