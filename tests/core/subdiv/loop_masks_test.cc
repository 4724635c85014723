#include "core/subdiv/loop_masks.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

namespace cagefit {
namespace {

constexpr int kMaxValence = 40;

// One refinement of an interior vertex (index 0) and its ring, from Loop's rules. The edge to ring
// vertex 0 is a crease when `dart` is set.
Eigen::MatrixXd RingRefinement(int k, bool dart) {
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(k + 1, k + 1);
  const double c = 3.0 / 8 + std::cos(2 * M_PI / k) / 4;
  const double beta = (5.0 / 8 - c * c) / k;
  S.row(0).setConstant(beta);
  S(0, 0) = 1 - k * beta;
  for (int i = 0; i < k; ++i) {
    S(1 + i, 0) = S(1 + i, 1 + i) = 3.0 / 8;
    S(1 + i, 1 + (i + 1) % k) += 1.0 / 8;
    S(1 + i, 1 + (i + k - 1) % k) += 1.0 / 8;
  }
  if (dart) {
    S.row(1).setZero();
    S(1, 0) = S(1, 1) = 0.5;
  }
  return S;
}

// What infinitely many refinements make of the vertex: the first row of S^(2^7).
Eigen::RowVectorXd LimitRow(Eigen::MatrixXd S) {
  for (int squaring = 0; squaring < 7; ++squaring) S = (S * S).eval();
  return S.row(0);
}

TEST(LoopBetaTest, HasItsClosedFormValues) {
  EXPECT_NEAR(LoopBeta(3), 3.0 / 16, 1e-15);
  EXPECT_NEAR(LoopBeta(4), 31.0 / 256, 1e-15);
  EXPECT_NEAR(LoopBeta(6), 1.0 / 16, 1e-15);
  // cos(pi / 6) = sqrt(3) / 2.
  EXPECT_NEAR(LoopBeta(12), (14 - 3 * std::sqrt(3.0)) / 384, 1e-15);
}

TEST(LoopBetaTest, LeavesTheVertexAPositiveWeight) {
  for (int k = 3; k <= kMaxValence; ++k) {
    EXPECT_GT(LoopBeta(k), 0) << "valence " << k;
    EXPECT_GT(1 - k * LoopBeta(k), 0.3) << "valence " << k;
  }
}

TEST(LoopLimitWeightTest, HasItsClosedFormValues) {
  EXPECT_NEAR(LoopLimitWeight(3), 1.0 / 5, 1e-15);
  EXPECT_NEAR(LoopLimitWeight(4), 31.0 / 220, 1e-15);
  EXPECT_NEAR(LoopLimitWeight(6), 1.0 / 12, 1e-15);
}

TEST(LoopLimitWeightTest, IsWhatRefiningWithoutEndGives) {
  for (int k = 3; k <= kMaxValence; ++k) {
    SCOPED_TRACE(k);
    const Eigen::RowVectorXd limit = LimitRow(RingRefinement(k, false));
    for (int i = 1; i <= k; ++i) EXPECT_NEAR(LoopLimitWeight(k), limit[i], 1e-12);
  }
}

TEST(LoopDartLimitWeightsTest, AreWhatRefiningWithoutEndGives) {
  for (int k = 3; k <= kMaxValence; ++k) {
    SCOPED_TRACE(k);
    const Eigen::RowVectorXd limit = LimitRow(RingRefinement(k, true));
    const std::vector<double> weights = LoopDartLimitWeights(k);
    ASSERT_EQ(weights.size(), k);
    double own = 1;
    for (int i = 0; i < k; ++i) {
      EXPECT_NEAR(weights[i], limit[1 + i], 1e-12);
      own -= weights[i];
    }
    EXPECT_NEAR(own, limit[0], 1e-12);
  }
}

TEST(LoopDartLimitWeightsTest, AreSymmetricAboutTheCrease) {
  for (int k = 3; k <= kMaxValence; ++k) {
    const std::vector<double> weights = LoopDartLimitWeights(k);
    for (int i = 1; i < k; ++i) EXPECT_NEAR(weights[i], weights[k - i], 1e-15) << "valence " << k;
  }
}

}  // namespace
}  // namespace cagefit
