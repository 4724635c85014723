#include "core/subdiv/loop_masks.h"

#include <cmath>

namespace cagefit {

double LoopBeta(int k) {
  constexpr double kPi = 3.14159265358979323846;
  const double c = 3.0 / 8.0 + std::cos(2 * kPi / k) / 4;
  return (5.0 / 8.0 - c * c) / k;
}

double LoopLimitWeight(int k) { return 1 / (k + 3 / (8 * LoopBeta(k))); }

}  // namespace cagefit
