#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "core/fit/adam.h"
#include "core/fit/ceres_solver.h"
#include "core/fit/fit_options.h"
#include "core/fit/gauss_newton.h"
#include "core/fit/normalization.h"
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

absl::StatusOr<Minimization> Minimize(Solver solver, const CancelFn& cancelled,
                                      testing::FitProblem* problem, Points3d* V) {
  SolverOptions options = Tight();
  options.relative_decrease = 1e-6;
  Objective* objective = &problem->objective;
  if (solver == Solver::kCeres) return MinimizeCeres(options, cancelled, objective, V);
  if (solver == Solver::kAdam) {
    options.max_iterations = 10'000;
    return MinimizeAdam(options, cancelled, objective, V);
  }
  StepSystem system(*objective);
  return MinimizeGaussNewton(options, cancelled, objective, &system, V);
}

const char* NameOf(Solver solver) {
  return solver == Solver::kGaussNewton ? "gauss_newton"
         : solver == Solver::kCeres     ? "ceres"
                                        : "adam";
}

// A start in the target's basin of attraction, and a radius at which no sample's is doubled.
struct Setting {
  ControlMesh cage;
  PointCloud cloud;
  double radius, coverage_weight;
  std::vector<Landmark> landmarks = {};
  BoundaryCurve boundary = {};
};

// Fits from the same start with each solver and compares the energies of where they end, under
// choices that an objective makes which has seen nothing else.
void ExpectTheSameMinimum(const Setting& setting, const std::vector<Solver>& solvers) {
  const auto make_problem = [&] {
    auto problem = std::make_unique<testing::FitProblem>(setting.cage, setting.cloud, 0.05,
                                                         setting.radius, setting.coverage_weight);
    problem->target.landmarks = setting.landmarks;
    problem->target.landmark_weight = 1;
    problem->target.boundary = &setting.boundary;
    problem->target.boundary_weight = 1;
    problem->objective.SetTarget(problem->target);
    return problem;
  };
  double first = 0;
  for (const Solver solver : solvers) {
    SCOPED_TRACE(NameOf(solver));
    const auto problem = make_problem(), judge = make_problem();
    Points3d V = setting.cage.vertices(), unused;
    const auto result = Minimize(solver, nullptr, problem.get(), &V);
    ASSERT_TRUE(result.ok()) << result.status();
    EXPECT_TRUE(result->converged);
    const double energy = judge->objective.Assign(V, &unused).total();
    EXPECT_EQ(judge->objective.distance().grown_samples(), 0);
    EXPECT_LT(energy, 0.2 * result->initial.total());
    EXPECT_NEAR(result->final.total(), energy, 1e-2 * energy);
    if (first == 0) first = energy;
    EXPECT_NEAR(energy, first, 1e-3 * first);
    ::testing::Test::RecordProperty(NameOf(solver), std::to_string(energy));
  }
}

constexpr Solver kAllSolvers[] = {Solver::kGaussNewton, Solver::kCeres, Solver::kAdam};

TEST(SolversTest, TheThreeSolversAgree) {
  for (const double coverage_weight : {0.0, 10.0}) {
    SCOPED_TRACE(coverage_weight);
    ExpectTheSameMinimum({testing::SphereCage(1, 0.45),
                          testing::EllipsoidCloud(2000, {0.5, 0.42, 0.38}), 0.1, coverage_weight},
                         {std::begin(kAllSolvers), std::end(kAllSolvers)});
  }
}

TEST(SolversTest, TheThreeSolversAgreeOnLandmarks) {
  ExpectTheSameMinimum({testing::SphereCage(1, 0.45),
                        testing::EllipsoidCloud(2000, {0.5, 0.42, 0.38}),
                        0.1,
                        0,
                        {{0, {}, {0.2, 0.3, 0.3}}, {-1, {20, 0.3, 0.3}, {0.1, -0.3, 0.2}}}},
                       {std::begin(kAllSolvers), std::end(kAllSolvers)});
}

// A disk, 8 % smaller than the target and turned, over the same plane.
TEST(SolversTest, TheThreeSolversAgreeOnBoundaries) {
  const TriangleMesh disk = testing::OpenDisk(3, 0.46), target = testing::OpenDisk(40, 0.5);
  const auto turn = Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX()).toRotationMatrix();
  ExpectTheSameMinimum({*ControlMesh::Create(turn * disk.vertices, disk.triangles),
                        CloudFromMesh(target),
                        0.1,
                        0,
                        {},
                        BoundaryOfMesh(target, 0.02)},
                       {std::begin(kAllSolvers), std::end(kAllSolvers)});
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

TEST(SolversTest, AllStopWhenCancelled) {
  for (const double coverage_weight : {0.0, 10.0}) {
    for (const Solver solver : kAllSolvers) {
      testing::FitProblem problem(0.05, 0.08, coverage_weight);
      Points3d V = problem.cage.vertices();
      int asked = 0;
      const CancelFn after_three = [&] { return ++asked > 3; };
      EXPECT_EQ(Minimize(solver, after_three, &problem, &V).status().code(),
                absl::StatusCode::kCancelled)
          << NameOf(solver);
      EXPECT_LT(asked, 10) << NameOf(solver);
    }
  }
}

// Held feet promise more than the surface keeps: it slides along itself.
TEST(SolversTest, CeresWithCoverageNeverEndsAboveWhereItBegan) {
  testing::FitProblem problem(5e-4, 0.1, 10);
  Points3d V = problem.cage.vertices();
  SolverOptions options = Tight();
  double before = 1e300;
  for (int round = 0; round < 4; ++round) {
    options.max_iterations = 5;
    const auto result = MinimizeCeres(options, nullptr, &problem.objective, &V);
    ASSERT_TRUE(result.ok());
    EXPECT_LE(result->final.total(), result->initial.total() * (1 + 1e-6));
    EXPECT_LT(result->final.total(), before);
    before = result->final.total();
  }
}

// In the unit box of the target.
Setting RealSetting(const std::string& control, const std::string& target, double radius,
                    double coverage_weight) {
  const TriangleMesh cage = testing::ReadTestMesh("control/" + control);
  PointCloud cloud = CloudFromMesh(testing::ReadTestMesh("static/" + target));
  const Normalization normalization = *Normalization::FromBox(BoundingBox(cloud.points));
  cloud.points = normalization.ToUnit(cloud.points.cast<double>()).cast<float>();
  return {*ControlMesh::Create(normalization.ToUnit(cage.vertices), cage.triangles), cloud, radius,
          coverage_weight};
}

Setting Bunny(double coverage_weight) {
  return RealSetting("bunny_314.obj", "bunny_closed_34835.ply", 0.06, coverage_weight);
}

Setting Spot(double coverage_weight) {
  return RealSetting("spot_829.obj", "spot_11533.ply", 0.08, coverage_weight);
}

TEST(SolversDataTest, TheThreeSolversAgreeOnTheBunny) {
  CAGEFIT_NEEDS_DATA();
  ExpectTheSameMinimum(Bunny(0), {std::begin(kAllSolvers), std::end(kAllSolvers)});
}

TEST(SolversDataTest, TheThreeSolversAgreeOnSpot) {
  CAGEFIT_NEEDS_DATA();
  ExpectTheSameMinimum(Spot(0), {std::begin(kAllSolvers), std::end(kAllSolvers)});
}

// Without Adam: with coverage it takes thousands of iterations even on small meshes.
TEST(SolversDataTest, GaussNewtonAndCeresAgreeOnTheBunnyWithCoverage) {
  CAGEFIT_NEEDS_DATA();
  ExpectTheSameMinimum(Bunny(10), {Solver::kGaussNewton, Solver::kCeres});
}

TEST(SolversDataTest, GaussNewtonAndCeresAgreeOnSpotWithCoverage) {
  CAGEFIT_NEEDS_DATA();
  ExpectTheSameMinimum(Spot(10), {Solver::kGaussNewton, Solver::kCeres});
}

}  // namespace
}  // namespace cagefit
