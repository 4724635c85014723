#include "core/fit/step_system.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <utility>

#include "core/fit/ceres_costs.h"
#include "tests/core/fit/fit_fixture.h"

namespace cagefit {
namespace {

// Normal matrix and right-hand side from the Jacobians of the Ceres costs, which are derived on
// their own.
void AssembleFromCosts(const Objective& objective, const Points3d& V, Eigen::MatrixXd* H,
                       Eigen::VectorXd* g) {
  const int64_t unknowns = 3 * V.cols();
  H->setZero(unknowns, unknowns);
  g->setZero(unknowns);
  const auto add = [&](const ceres::CostFunction& cost, const std::vector<int64_t>& vertices) {
    const int rows = cost.num_residuals();
    Eigen::VectorXd r(rows);
    std::vector<std::vector<double>> storage(vertices.size(), std::vector<double>(rows * 3));
    std::vector<double*> jacobians;
    std::vector<const double*> parameters;
    for (size_t k = 0; k < vertices.size(); ++k) {
      jacobians.push_back(storage[k].data());
      parameters.push_back(V.col(vertices[k]).data());
    }
    ASSERT_TRUE(cost.Evaluate(parameters.data(), r.data(), jacobians.data()));
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
    for (size_t a = 0; a < vertices.size(); ++a) {
      const Eigen::Map<const RowMajor> J_a(storage[a].data(), rows, 3);
      g->segment<3>(3 * vertices[a]) += J_a.transpose() * r;
      for (size_t b = 0; b < vertices.size(); ++b) {
        const Eigen::Map<const RowMajor> J_b(storage[b].data(), rows, 3);
        H->block<3, 3>(3 * vertices[a], 3 * vertices[b]) += J_a.transpose() * J_b;
      }
    }
  };
  for (int64_t i = 0; i < objective.stencils().rows(); ++i) {
    std::vector<double> weights;
    std::vector<int64_t> vertices;
    for (StencilMatrix::InnerIterator s(objective.stencils(), i); s; ++s) {
      weights.push_back(s.value());
      vertices.push_back(s.col());
    }
    add(SampleCost(objective.distance(), i, weights), vertices);
  }
  for (const Attachments* set : objective.attachments()) {
    for (int64_t k = 0; k < set->size(); ++k) {
      std::vector<double> weights;
      std::vector<int64_t> vertices;
      for (StencilMatrix::InnerIterator s(set->rows, k); s; ++s) {
        weights.push_back(s.value());
        vertices.push_back(s.col());
      }
      add(AttachmentCost(set->weights[k], set->targets.col(k), weights), vertices);
    }
  }
  const ArapTerm& arap = objective.arap();
  for (int32_t i = 0; i < arap.vertex_count(); ++i) {
    std::vector<int64_t> vertices = {i};
    for (int32_t e = arap.begin(i); e < arap.begin(i + 1); ++e)
      vertices.push_back(arap.neighbor(e));
    add(ArapCost(arap, i, objective.arap_weight()), vertices);
  }
}

TEST(StepSystemTest, SolvesTheNormalEquationsOfTheCeresCosts) {
  testing::FitProblem problem(0.05);
  const Points3d V = problem.cage.vertices();
  const std::vector<Landmark> landmarks = {
      {7, {}, 1.05 * V.col(7)}, {-1, {5, 0.2, 0.3}, 0.9 * V.col(problem.cage.triangles()(0, 5))}};
  problem.target.landmarks = landmarks;
  problem.target.landmark_weight = 1;
  problem.objective.SetTarget(problem.target);
  Points3d half_gradient, step;
  problem.objective.Assign(V, &half_gradient);
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  AssembleFromCosts(problem.objective, V, &H, &g);
  const Eigen::VectorXd flat =
      Eigen::Map<const Eigen::VectorXd>(half_gradient.data(), half_gradient.size());
  EXPECT_NEAR((g - flat).norm(), 0, 1e-9 * g.norm());

  StepSystem system(problem.objective);
  system.Linearize(problem.objective);
  // The diagonal that scales the damping leaves out the share of the rotations, so it differs a
  // little from H's: by less, the less there is of it.
  for (const auto& [damping, tolerance] : {std::pair(1e-3, 1e-2), {1e-5, 5e-4}}) {
    double promised = 0;
    system.Solve(half_gradient, damping, 1e-6, 2000, nullptr, &step, &promised);
    Eigen::MatrixXd damped = H;
    damped.diagonal().array() += damping * H.trace() / static_cast<double>(H.rows());
    const Eigen::VectorXd exact = damped.ldlt().solve(-g);
    const Eigen::VectorXd solved = Eigen::Map<const Eigen::VectorXd>(step.data(), step.size());
    EXPECT_LT((solved - exact).norm(), tolerance * exact.norm());
    EXPECT_NEAR(promised, -2 * solved.dot(g) - solved.dot(H * solved), 1e-3 * promised);
  }
}

TEST(StepSystemTest, StopsWhenCancelled) {
  testing::FitProblem problem(0.05);
  Points3d half_gradient, step;
  problem.objective.Assign(problem.cage.vertices(), &half_gradient);
  StepSystem system(problem.objective);
  system.Linearize(problem.objective);
  double promised = 0;
  EXPECT_EQ(system.Solve(
                half_gradient, 0, 1e-9, 1000, [] { return true; }, &step, &promised),
            0);
}

}  // namespace
}  // namespace cagefit
