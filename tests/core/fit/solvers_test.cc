#include <gtest/gtest.h>

#include "core/fit/ceres_solver.h"
#include "core/fit/gauss_newton.h"
#include "tests/core/fit/fit_fixture.h"
#include "tests/support/data.h"
#include "tests/support/mesh_file.h"

namespace cagefit {
namespace {

SolverOptions Tight() {
  SolverOptions options;
  options.max_iterations = 2000;
  options.relative_decrease = 1e-7;
  options.first_stiffness = 1;
  return options;
}

TEST(SolversTest, GaussNewtonAndCeresReachTheSameMinimum) {
  testing::FitProblem a(0.05), b(0.05);
  StepSystem system(a.objective);
  Points3d V_a = a.cage.vertices(), V_b = V_a;
  const auto newton = MinimizeGaussNewton(Tight(), nullptr, &a.objective, &system, &V_a);
  const auto ceres = MinimizeCeres(Tight(), nullptr, &b.objective, &V_b);
  ASSERT_TRUE(newton.ok()) << newton.status();
  ASSERT_TRUE(ceres.ok()) << ceres.status();
  EXPECT_TRUE(newton->converged);
  EXPECT_LT(newton->final.total(), 0.1 * newton->initial.total());
  EXPECT_NEAR(newton->final.total(), ceres->final.total(), 1e-3 * ceres->final.total());
}

TEST(SolversTest, ContinuationEndsInTheSameMinimum) {
  testing::FitProblem a(0.05), b(0.05);
  StepSystem system(a.objective);
  Points3d V_a = a.cage.vertices(), V_b = V_a;
  SolverOptions stiff = Tight();
  stiff.first_stiffness = 1000;
  const auto plain = MinimizeGaussNewton(Tight(), nullptr, &a.objective, &system, &V_a);
  const auto continued = MinimizeGaussNewton(stiff, nullptr, &b.objective, &system, &V_b);
  ASSERT_TRUE(plain.ok() && continued.ok());
  EXPECT_NEAR(continued->final.total(), plain->final.total(), 1e-3 * plain->final.total());
}

TEST(SolversTest, BothStopWhenCancelled) {
  testing::FitProblem a(0.05);
  StepSystem system(a.objective);
  Points3d V = a.cage.vertices();
  int asked = 0;
  const CancelFn after_three = [&] { return ++asked > 3; };
  EXPECT_EQ(MinimizeGaussNewton(Tight(), after_three, &a.objective, &system, &V).status().code(),
            absl::StatusCode::kCancelled);
  asked = 0;
  EXPECT_EQ(MinimizeCeres(Tight(), after_three, &a.objective, &V).status().code(),
            absl::StatusCode::kCancelled);
}

TEST(SolversDataTest, ReachTheSameMinimumOnTheBunny) {
  CAGEFIT_NEEDS_DATA();
  const TriangleMesh cage_mesh = testing::ReadTestMesh("control/bunny_314.obj");
  const ControlMesh cage = *ControlMesh::Create(cage_mesh.vertices, cage_mesh.triangles);
  const PointCloud target = CloudFromMesh(testing::ReadTestMesh("static/bunny_closed_34835.ply"));
  TargetIndex index;
  ASSERT_TRUE(index.Build(target, 0.01, 2).ok());
  double energy[2];
  for (const bool use_ceres : {false, true}) {
    Objective objective(cage.topology(), BuildLimitMesh(cage.topology(), cage.tags(), 1).position,
                        0.003);
    objective.SetTarget(&index, 0.03);
    objective.SetRest(cage.vertices());
    StepSystem system(objective);
    Points3d V = cage.vertices();
    SolverOptions options = Tight();
    options.relative_decrease = 1e-6;
    const auto result = use_ceres ? MinimizeCeres(options, nullptr, &objective, &V)
                                  : MinimizeGaussNewton(options, nullptr, &objective, &system, &V);
    ASSERT_TRUE(result.ok()) << result.status();
    energy[use_ceres] = result->final.total();
    RecordProperty(use_ceres ? "ceres" : "gauss_newton", std::to_string(energy[use_ceres]));
  }
  EXPECT_NEAR(energy[0], energy[1], 1e-3 * energy[1]);
}

}  // namespace
}  // namespace cagefit
