#include "core/subdiv/loop_masks.h"

#include <cmath>

namespace cagefit {

double LoopBeta(int k) {
  constexpr double kPi = 3.14159265358979323846;
  const double c = 3.0 / 8.0 + std::cos(2 * kPi / k) / 4;
  return (5.0 / 8.0 - c * c) / k;
}

double LoopLimitWeight(int k) { return 1 / (k + 3 / (8 * LoopBeta(k))); }

// The limit mask is the left eigenvector for eigenvalue 1 of the refinement of v and its ring, here
// scaled so that v has weight 1. Ring vertex 0 lies on the crease and passes nothing to its
// neighbours, so their columns read, with l_0 = l_k = 0 for the moment,
//   beta + 3/8 l_i + 1/8 (l_{i-1} + l_{i+1}) = l_i,  i = 1 .. k - 1,
// solved by 8/3 beta (1 - (z^i + z^(k-i)) / (1 + z^k)) where z + 1/z = 5. Column 0 then gives
//   beta + 1/2 l_0 + 1/8 (l_1 + l_{k-1}) = l_0.
std::vector<double> LoopDartLimitWeights(int k) {
  const double beta = LoopBeta(k);
  const double z = (5 - std::sqrt(21.0)) / 2;
  std::vector<double> weights(k);
  double sum = 1;
  for (int i = 1; i < k; ++i) {
    weights[i] = 8 * beta / 3 * (1 - (std::pow(z, i) + std::pow(z, k - i)) / (1 + std::pow(z, k)));
    sum += weights[i];
  }
  weights[0] = 2 * beta + (weights[1] + weights[k - 1]) / 4;
  sum += weights[0];
  for (double& weight : weights) weight /= sum;
  return weights;
}

}  // namespace cagefit
