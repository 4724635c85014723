#include "core/energy/arap_term.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "core/mesh/control_mesh.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

Points3d Disturbed(const Points3d& V, double amount, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-amount, amount);
  return V + Points3d::NullaryExpr(3, V.cols(), [&] { return uniform(random); });
}

class ArapTermTest : public ::testing::TestWithParam<bool> {
 protected:
  ArapTermTest()
      : mesh_(GetParam() ? testing::MixedValences() : testing::OpenGrid(6)),
        topology_(*Topology::Create(static_cast<int32_t>(mesh_.vertices.cols()), mesh_.triangles)),
        term_(topology_) {
    term_.SetRest(mesh_.vertices);
  }
  double EnergyAt(const Points3d& V) {
    term_.UpdateRotations(V);
    return term_.Evaluate(V, nullptr);
  }
  TriangleMesh mesh_;
  Topology topology_;
  ArapTerm term_;
};
INSTANTIATE_TEST_SUITE_P(ClosedAndOpen, ArapTermTest, ::testing::Bool());

TEST_P(ArapTermTest, IsZeroForRigidMotions) {
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const Points3d V = (R * mesh_.vertices).colwise() + Eigen::Vector3d(3, -1, 2);
  EXPECT_NEAR(EnergyAt(V), 0, 1e-20);
}

TEST_P(ArapTermTest, GrowsWithTheSquareOfAUniformScale) {
  // e = s e' and R = I: sum w |e'|^2 (s - 1)^2.
  EXPECT_NEAR(EnergyAt(1.2 * mesh_.vertices) / EnergyAt(1.1 * mesh_.vertices), 4, 1e-9);
}

TEST_P(ArapTermTest, GradientAgreesWithFiniteDifferences) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Points3d V = Disturbed(mesh_.vertices, 0.05, seed);
    Points3d half_gradient;
    term_.UpdateRotations(V);
    term_.Evaluate(V, &half_gradient);
    const double scale = half_gradient.norm();
    for (int64_t i = 0; i < V.cols(); i += 7) {
      for (int axis = 0; axis < 3; ++axis) {
        const double step = 1e-5;
        Points3d ahead = V, behind = V;
        ahead(axis, i) += step;
        behind(axis, i) -= step;
        const double difference = (EnergyAt(ahead) - EnergyAt(behind)) / (2 * step);
        EXPECT_NEAR(2 * half_gradient(axis, i), difference, 1e-6 * scale);
      }
    }
  }
}

TEST_P(ArapTermTest, GradientIsZeroAtTheRestMesh) {
  Points3d half_gradient;
  term_.UpdateRotations(mesh_.vertices);
  term_.Evaluate(mesh_.vertices, &half_gradient);
  EXPECT_NEAR(half_gradient.norm(), 0, 1e-12);
}

TEST_P(ArapTermTest, StaysFiniteOnACollapsedMesh) {
  const Points3d V = Points3d::Constant(3, mesh_.vertices.cols(), 0.5);
  Points3d half_gradient;
  term_.UpdateRotations(V);
  EXPECT_TRUE(std::isfinite(term_.Evaluate(V, &half_gradient)));
  EXPECT_TRUE(half_gradient.allFinite());
}

TEST(ArapWeightsTest, AreHalfTheSumOfOppositeCotangents) {
  // Two right isosceles triangles on the unit square: the diagonal sees two right angles, each side
  // one of 45 degrees.
  const TriangleMesh square = testing::OpenGrid(1);
  const Topology topology = *Topology::Create(4, square.triangles);
  ArapTerm term(topology);
  term.SetRest(square.vertices);
  for (int32_t i = 0; i < 4; ++i) {
    for (int32_t e = term.begin(i); e < term.begin(i + 1); ++e) {
      const double length = (square.vertices.col(i) - square.vertices.col(term.neighbor(e))).norm();
      EXPECT_NEAR(term.weight(e), length > 1.2 ? ArapTerm::kMinWeight : 0.5, 1e-12);
    }
  }
}

}  // namespace
}  // namespace cagefit
