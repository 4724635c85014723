#include "core/fit/objective.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <utility>

#include "core/subdiv/surface_sampler.h"
#include "tests/core/fit/fit_fixture.h"
#include "tests/core/subdiv/surface_samples.h"

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

// A cube of 0.8 whose edges are creases, about the origin.
ControlMesh CreasedCage() {
  const TriangleMesh cube = testing::Cube(4);
  const Points3d V = 0.8 * (cube.vertices.array() - 0.5);
  CreaseTags tags = testing::SharpEdges(testing::TopologyOf(cube), V, 30);
  return *ControlMesh::Create(V, cube.triangles, std::move(tags));
}

TEST(ObjectiveTest, GradientOfAllTermsTogetherAgreesWithFiniteDifferencesOnACreasedMesh) {
  const ControlMesh cage = CreasedCage();
  ASSERT_EQ(cage.tags().edges.size(), 12 * 4);
  const PointCloud cloud = testing::EllipsoidCloud(4000, {0.5, 0.45, 0.4});
  TargetIndex index;
  ASSERT_TRUE(index.Build(cloud, 0.08, 2).ok());
  const std::vector<Landmark> landmarks = {{7, {}, {0.1, 0.2, 0.3}},
                                           {-1, {5, 0.2, 0.3}, {0, 0, 1}}};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-0.02, 0.02);
  for (const Sampling sampling :
       {Sampling::kControlVertices, Sampling::kRefinedVertices, Sampling::kArea}) {
    for (const Field field : {Field::kImls, Field::kRimls}) {
      for (const Kernel kernel : {Kernel::kIdentity, Kernel::kGemanMcClure}) {
        Objective objective(cage.topology(), *SampleStencils(cage, sampling, 3, 1), 0.05,
                            testing::TermsFor(cage, 3));
        ObjectiveTarget target;
        target.index = &index;
        target.far_radius = 0.1;
        target.field = field;
        target.kernel = {kernel, 0.05};
        target.covered = &cloud;
        target.coverage_weight = 3;
        target.landmarks = landmarks;
        target.landmark_weight = 2;
        objective.SetTarget(target);
        objective.SetRest(cage.vertices());
        const Points3d V = cage.vertices() + Points3d::NullaryExpr(3, cage.vertex_count(),
                                                                   [&] { return uniform(random); });
        Points3d half_gradient, unused;
        objective.Assign(V, &half_gradient);
        const Energies energies = objective.Evaluate(V, &half_gradient);
        ASSERT_GT(
            std::min({energies.distance, energies.arap, energies.coverage, energies.landmarks}),
            1e-3);
        ASSERT_GT(objective.distance().far_samples(), 0);
        const double scale = half_gradient.colwise().norm().maxCoeff();
        for (int64_t i = 0; i < V.cols(); i += 9) {
          for (int axis = 0; axis < 3; ++axis) {
            const double step = 1e-6;
            Points3d ahead = V, behind = V;
            ahead(axis, i) += step;
            behind(axis, i) -= step;
            const double difference = (objective.Evaluate(ahead, &unused).total() -
                                       objective.Evaluate(behind, &unused).total()) /
                                      (2 * step);
            EXPECT_NEAR(2 * half_gradient(axis, i), difference, 1e-6 * scale)
                << "sampling " << static_cast<int>(sampling) << ", vertex " << i;
          }
        }
      }
    }
  }
}

TEST(ObjectiveTest, FeetMayFollowWhileSamplesAreHeld) {
  testing::FitProblem problem(0.05, 0.08, 10);
  const Points3d start = problem.cage.vertices();
  const Points3d V = start.colwise() + Eigen::Vector3d(0.1, 0.05, 0);
  Points3d half_gradient, anew_half_gradient;
  problem.objective.Assign(start, &half_gradient);
  const Energies held = problem.objective.Evaluate(V, &half_gradient);
  const Energies followed = problem.objective.AssignFeet(V, &half_gradient);
  EXPECT_EQ(followed.distance, held.distance);
  EXPECT_EQ(followed.arap, held.arap);
  const Energies anew = problem.objective.Assign(V, &anew_half_gradient);
  EXPECT_NEAR(followed.coverage, anew.coverage, 1e-4 * anew.coverage);
  EXPECT_GT(std::abs(held.coverage - anew.coverage), 1e-2 * anew.coverage);
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
