#include "core/fit/objective.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/core/fit/fit_fixture.h"

namespace cagefit {
namespace {

TEST(ObjectiveTest, GradientAgreesWithFiniteDifferencesAtHeldRadiusAndBranch) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-0.02, 0.02);
  for (const double arap_weight : {0.0, 0.05}) {
    testing::FitProblem problem(arap_weight);
    Points3d V = problem.cage.vertices() + Points3d::NullaryExpr(3, problem.cage.vertex_count(),
                                                                 [&] { return uniform(random); });
    Points3d half_gradient, unused;
    problem.objective.Assign(V, &half_gradient);
    ASSERT_GT(problem.objective.distance().grown_samples(), 0);
    const double scale = half_gradient.colwise().norm().maxCoeff();
    for (int64_t i = 0; i < V.cols(); i += 5) {
      for (int axis = 0; axis < 3; ++axis) {
        const double step = 1e-6;
        Points3d ahead = V, behind = V;
        ahead(axis, i) += step;
        behind(axis, i) -= step;
        const double difference = (problem.objective.Evaluate(ahead, &unused).total() -
                                   problem.objective.Evaluate(behind, &unused).total()) /
                                  (2 * step);
        EXPECT_NEAR(2 * half_gradient(axis, i), difference, 1e-6 * scale);
      }
    }
  }
}

TEST(ObjectiveTest, ReevaluatesUnderAnotherAlphaToTheBit) {
  testing::FitProblem problem(0.01);
  const Points3d V = 0.9 * problem.cage.vertices();
  Points3d unused, again, anew;
  problem.objective.Assign(V, &unused);
  problem.objective.set_arap_weight(0.5);
  const Energies cheap = problem.objective.Reevaluate(V, &again);
  const Energies full = problem.objective.Evaluate(V, &anew);
  EXPECT_EQ(cheap.distance, full.distance);
  EXPECT_EQ(cheap.arap, full.arap);
  EXPECT_EQ(again, anew);
}

TEST(ObjectiveTest, WeighsTheRegulariserByAlpha) {
  testing::FitProblem weak(0.01), strong(0.04);
  Points3d V = 0.9 * weak.cage.vertices(), unused;
  EXPECT_NEAR(strong.objective.Assign(V, &unused).arap, 4 * weak.objective.Assign(V, &unused).arap,
              1e-12);
}

}  // namespace
}  // namespace cagefit
