#include "core/fit/ceres_costs.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/core/fit/fit_fixture.h"

namespace cagefit {
namespace {

// Residuals of `cost` as a function of its parameters, checked by central differences.
void CheckJacobian(const ceres::CostFunction& cost, std::vector<Eigen::Vector3d> x,
                   double tolerance) {
  const int rows = cost.num_residuals();
  std::vector<const double*> parameters;
  std::vector<std::vector<double>> storage(x.size(), std::vector<double>(rows * 3));
  std::vector<double*> jacobians;
  for (size_t k = 0; k < x.size(); ++k) {
    parameters.push_back(x[k].data());
    jacobians.push_back(storage[k].data());
  }
  std::vector<double> r(rows), ahead(rows), behind(rows);
  ASSERT_TRUE(cost.Evaluate(parameters.data(), r.data(), jacobians.data()));
  for (size_t k = 0; k < x.size(); ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      const double step = 1e-6, at = x[k][axis];
      x[k][axis] = at + step;
      cost.Evaluate(parameters.data(), ahead.data(), nullptr);
      x[k][axis] = at - step;
      cost.Evaluate(parameters.data(), behind.data(), nullptr);
      x[k][axis] = at;
      for (int row = 0; row < rows; ++row) {
        EXPECT_NEAR(storage[k][3 * row + axis], (ahead[row] - behind[row]) / (2 * step), tolerance);
      }
    }
  }
}

TEST(CeresCostsTest, SampleJacobianAgreesWithFiniteDifferences) {
  testing::FitProblem problem(0.05);
  Points3d unused;
  const Points3d V = problem.cage.vertices();
  problem.objective.Assign(V, &unused);
  for (int64_t i = 0; i < problem.objective.stencils().rows(); i += 37) {
    std::vector<double> weights;
    std::vector<Eigen::Vector3d> x;
    for (StencilMatrix::InnerIterator s(problem.objective.stencils(), i); s; ++s) {
      weights.push_back(s.value());
      x.push_back(V.col(s.col()));
    }
    CheckJacobian(SampleCost(problem.objective.distance(), i, weights), x, 1e-6);
  }
}

TEST(CeresCostsTest, CoverageJacobianAgreesWithFiniteDifferencesUnderEveryKernel) {
  CoverageTerm::Row row;
  row.direction = Eigen::Vector3d(1, -2, 2) / 3;
  row.target = Eigen::Vector3d(0.3, 0.1, -0.2);
  row.scale = 0.7;
  const std::vector<Eigen::Vector3d> x = {{0.1, 0.2, 0.3}, {-0.4, 0.5, 0.1}, {0.3, -0.1, 0.2}};
  for (const Kernel kernel :
       {Kernel::kIdentity, Kernel::kHuber, Kernel::kGemanMcClure, Kernel::kTukey}) {
    for (const double scale : {0.05, 0.2, 10.0}) {
      CheckJacobian(CoverageCost(row, {kernel, scale}, {0.2, 0.3, 0.5}), x, 1e-6);
    }
  }
}

TEST(CeresCostsTest, AttachmentIsItsEnergyAndItsJacobianAgreesWithFiniteDifferences) {
  const Eigen::Vector3d t = Eigen::Vector3d(1, 2, -2) / 3, target(0.3, 0.1, -0.2);
  const std::vector<Eigen::Vector3d> x = {{0.1, 0.2, 0.3}, {-0.4, 0.5, 0.1}, {0.3, -0.1, 0.2}};
  const std::vector<double> stencil = {0.2, 0.3, 0.5};
  Eigen::Vector3d X = -target;
  for (size_t k = 0; k < x.size(); ++k) X += stencil[k] * x[k];
  for (const Eigen::Matrix3d& weight :
       {Eigen::Matrix3d(2.5 * Eigen::Matrix3d::Identity()),
        Eigen::Matrix3d(0.4 * (Eigen::Matrix3d::Identity() - t * t.transpose()))}) {
    const AttachmentCost cost(weight, target, stencil);
    CheckJacobian(cost, x, 1e-6);
    std::vector<const double*> parameters;
    for (const Eigen::Vector3d& v : x) parameters.push_back(v.data());
    Eigen::Vector3d r;
    ASSERT_TRUE(cost.Evaluate(parameters.data(), r.data(), nullptr));
    EXPECT_NEAR(r.squaredNorm(), X.dot(weight * X), 1e-12);
  }
}

TEST(CeresCostsTest, ArapJacobianAgreesWithFiniteDifferencesAtTheRestShape) {
  // At zero residual the first-order rotation is exact; elsewhere the Jacobian is that of Gauss and
  // Newton.
  testing::FitProblem problem(0.05);
  const Points3d V = problem.cage.vertices();
  const ArapTerm& arap = problem.objective.arap();
  for (int32_t i = 0; i < arap.vertex_count(); i += 11) {
    std::vector<Eigen::Vector3d> x = {V.col(i)};
    for (int32_t e = arap.begin(i); e < arap.begin(i + 1); ++e)
      x.push_back(V.col(arap.neighbor(e)));
    CheckJacobian(ArapCost(arap, i, 0.05), x, 1e-6);
  }
}

}  // namespace
}  // namespace cagefit
