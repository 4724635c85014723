#include "core/fit/adam.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/fit/fit_fixture.h"

namespace cagefit {
namespace {

SolverOptions Steps(int iterations, double learning_rate) {
  SolverOptions options;
  options.solver = Solver::kAdam;
  options.max_iterations = iterations;
  options.relative_decrease = 1e-9;
  options.learning_rate = learning_rate;
  return options;
}

// The header's recursion, per coordinate, on an objective of its own.
Points3d NaiveAdam(testing::FitProblem* problem, Points3d V, int steps, double rate) {
  Points3d half_gradient, m = Points3d::Zero(3, V.cols()), v = m;
  for (int t = 1; t <= steps; ++t) {
    problem->objective.AssignSamples(V, &half_gradient);
    for (int64_t k = 0; k < V.size(); ++k) {
      const double g = 2 * half_gradient.data()[k];
      m.data()[k] = 0.9 * m.data()[k] + 0.1 * g;
      v.data()[k] = 0.999 * v.data()[k] + 0.001 * g * g;
      const double m_hat = m.data()[k] / (1 - std::pow(0.9, t));
      const double v_hat = v.data()[k] / (1 - std::pow(0.999, t));
      V.data()[k] -= rate * m_hat / (std::sqrt(v_hat) + 1e-8);
    }
  }
  return V;
}

TEST(AdamTest, FirstStepIsTheLearningRateAgainstTheSignOfTheGradient) {
  for (const double coverage_weight : {0.0, 10.0}) {
    testing::FitProblem problem(0.05, 0.08, coverage_weight);
    const Points3d start = problem.cage.vertices();
    Points3d V = start, half_gradient;
    problem.objective.Assign(V, &half_gradient);
    ASSERT_TRUE(MinimizeAdam(Steps(1, 1e-4), nullptr, &problem.objective, &V).ok());
    for (int64_t k = 0; k < V.size(); ++k) {
      const double g = 2 * half_gradient.data()[k];
      EXPECT_NEAR(V.data()[k] - start.data()[k], -1e-4 * g / (std::abs(g) + 1e-8), 1e-13);
    }
  }
}

TEST(AdamTest, LaterStepsFollowTheRecursion) {
  testing::FitProblem a(0.05), b(0.05);
  Points3d V = a.cage.vertices();
  const auto result = MinimizeAdam(Steps(12, 1e-3), nullptr, &a.objective, &V);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->iterations, 12);
  EXPECT_NEAR((V - NaiveAdam(&b, b.cage.vertices(), 12, 1e-3)).cwiseAbs().maxCoeff(), 0, 1e-12);
}

TEST(AdamTest, LowersTheEnergy) {
  for (const double coverage_weight : {0.0, 10.0}) {
    testing::FitProblem problem(0.05, 0.08, coverage_weight), judge(0.05, 0.08, coverage_weight);
    Points3d V = problem.cage.vertices(), unused;
    const auto result = MinimizeAdam(Steps(300, 1e-3), nullptr, &problem.objective, &V);
    ASSERT_TRUE(result.ok());
    EXPECT_LT(result->final.total(), 0.1 * result->initial.total());
    const double energy = judge.objective.Assign(V, &unused).total();
    EXPECT_NEAR(result->final.total(), energy, 1e-3 * energy);
  }
}

TEST(AdamTest, KeepsTheIterateOfLeastEnergy) {
  testing::FitProblem a(0.05), b(0.05);
  Points3d minimum = a.cage.vertices();
  const auto good = MinimizeAdam(Steps(2000, 1e-3), nullptr, &a.objective, &minimum);
  ASSERT_TRUE(good.ok());
  // From near the minimum each step is far too long.
  Points3d V = minimum;
  const auto wild = MinimizeAdam(Steps(20, 0.3), nullptr, &b.objective, &V);
  ASSERT_TRUE(wild.ok());
  EXPECT_EQ(wild->iterations, 20);
  EXPECT_EQ(V, minimum);
  // Rotations begin where the last ones were, and so end elsewhere by rounding.
  EXPECT_NEAR(wild->final.total(), wild->initial.total(), 1e-12 * wild->initial.total());
}

TEST(AdamTest, EndsAfterAWindowThatLoweredTheEnergyByTooLittle) {
  testing::FitProblem a(0.05), b(0.05);
  Points3d V_a = a.cage.vertices(), V_b = V_a;
  SolverOptions loose = Steps(10'000, 1e-3), looser = loose;
  loose.relative_decrease = 1e-4;
  looser.relative_decrease = 0.5;
  const auto longer = MinimizeAdam(loose, nullptr, &a.objective, &V_a);
  const auto shorter = MinimizeAdam(looser, nullptr, &b.objective, &V_b);
  ASSERT_TRUE(longer.ok() && shorter.ok());
  for (const Minimization& result : {*longer, *shorter}) {
    EXPECT_TRUE(result.converged);
    EXPECT_EQ(result.iterations % kAdamWindow, 0);
    EXPECT_LT(result.iterations, 10'000);
  }
  EXPECT_LT(shorter->iterations, longer->iterations);
  EXPECT_LE(longer->final.total(), shorter->final.total());
}

TEST(AdamTest, HasNotConvergedBeforeAWindowIsFull) {
  testing::FitProblem problem(0.05);
  Points3d V = problem.cage.vertices();
  const auto result = MinimizeAdam(Steps(kAdamWindow - 1, 1e-3), nullptr, &problem.objective, &V);
  ASSERT_TRUE(result.ok());
  EXPECT_FALSE(result->converged);
  EXPECT_EQ(result->iterations, kAdamWindow - 1);
}

}  // namespace
}  // namespace cagefit
