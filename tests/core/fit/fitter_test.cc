#include "core/fit/fitter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/core/fit/fit_fixture.h"

namespace cagefit {
namespace {

constexpr double kUserScale = 250;  // the tests' user unit is a millimetre
const Eigen::Vector3d kCentre(10, 20, 30);

PointCloud UserCloud(double wave) {
  PointCloud cloud = testing::EllipsoidCloud(8000, {0.5, 0.4 + wave, 0.3});
  cloud.points = (static_cast<float>(kUserScale) * cloud.points).colwise() + kCentre.cast<float>();
  return cloud;
}

class FitterTest : public ::testing::Test {
 protected:
  FitterTest() : cage_(testing::SphereCage(2, 0.45 * kUserScale)) {
    cage_ = cage_.WithVertices(cage_.vertices().colwise() + kCentre);
    normalization_ = *Normalization::FromBox(BoundingBox(UserCloud(0).points));
  }
  Fitter MakeFitter(const FitOptions& options = {}) {
    return *Fitter::Create(cage_, normalization_, options);
  }
  // Largest |(x/a)^2 + (y/b)^2 + (z/c)^2 - 1| on the limit surface, 0 where it is the target.
  double EllipsoidError(const Points3d& V) const {
    Points3d Q;
    ApplyStencils(BuildLimitMesh(cage_.topology(), cage_.tags(), 2).position, V, &Q);
    const Eigen::Array3Xd unit =
        ((Q.colwise() - kCentre) / kUserScale).array().colwise() / Eigen::Array3d(0.5, 0.4, 0.3);
    return (unit.square().colwise().sum() - 1).abs().maxCoeff();
  }

  ControlMesh cage_ = testing::SphereCage(0, 1);
  Normalization normalization_;
};

TEST_F(FitterTest, LimitSurfaceReachesTheTarget) {
  Fitter fitter = MakeFitter();
  Points3d fitted;
  const auto summary = fitter.Fit(UserCloud(0), {cage_.vertices()}, nullptr, nullptr, &fitted);
  ASSERT_TRUE(summary.ok()) << summary.status();
  EXPECT_TRUE(summary->converged);
  EXPECT_LT(EllipsoidError(fitted), 0.02);
}

TEST_F(FitterTest, AStartThatIsFarOffReachesTheSameSurface) {
  const Eigen::Vector3d shift = kUserScale * Eigen::Vector3d(0.3, -0.2, 0.1);
  for (const double scale : {0.7, 1.3}) {
    const ControlMesh moved = cage_.WithVertices(
        (scale * (cage_.vertices().colwise() - kCentre)).colwise() + (kCentre + shift));
    Points3d fitted;
    const auto summary = Fitter::Create(moved, normalization_, FitOptions())
                             ->Fit(UserCloud(0), {moved.vertices()}, nullptr, nullptr, &fitted);
    ASSERT_TRUE(summary.ok()) << summary.status();
    EXPECT_LT(EllipsoidError(fitted), 0.02) << scale;
  }
}

TEST_F(FitterTest, EverySamplingReachesTheTarget) {
  for (const Sampling sampling : {Sampling::kControlVertices, Sampling::kArea}) {
    FitOptions options;
    options.distance.sampling = sampling;
    Fitter fitter = MakeFitter(options);
    Points3d fitted;
    const auto summary = fitter.Fit(UserCloud(0), {cage_.vertices()}, nullptr, nullptr, &fitted);
    ASSERT_TRUE(summary.ok()) << summary.status();
    EXPECT_TRUE(summary->converged);
    EXPECT_LT(EllipsoidError(fitted), 0.02) << static_cast<int>(sampling);
  }
}

TEST_F(FitterTest, IsAPureFunctionOfItsArguments) {
  Fitter used = MakeFitter(), fresh = MakeFitter();
  Points3d first, second, again, other;
  ASSERT_TRUE(used.Fit(UserCloud(0), {cage_.vertices()}, nullptr, nullptr, &first).ok());
  ASSERT_TRUE(used.Fit(UserCloud(0.05), {first}, nullptr, nullptr, &second).ok());
  ASSERT_TRUE(fresh.Fit(UserCloud(0.05), {first}, nullptr, nullptr, &again).ok());
  EXPECT_EQ(second, again);
  EXPECT_NE(first, second);
}

TEST_F(FitterTest, ARefusedFrameLeavesTheResultAlone) {
  Fitter fitter = MakeFitter();
  Points3d fitted = Points3d::Constant(3, 1, 7);
  PointCloud bad = UserCloud(0);
  bad.points(1, 17) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(fitter.Fit(bad, {cage_.vertices()}, nullptr, nullptr, &fitted).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(fitter
                .Fit(
                    UserCloud(0), {cage_.vertices()}, [] { return true; }, nullptr, &fitted)
                .status()
                .code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(fitted, Points3d::Constant(3, 1, 7));
}

TEST_F(FitterTest, BeginsAtTheStartNearestToTheTarget) {
  Fitter fitter = MakeFitter(FitOptions());
  const Points3d far = cage_.vertices().colwise() + Eigen::Vector3d(0, 0, 0.1 * kUserScale);
  Points3d fitted, alone;
  const auto first = fitter.Fit(UserCloud(0), {cage_.vertices(), far}, nullptr, nullptr, &fitted);
  const auto second = fitter.Fit(UserCloud(0), {far, cage_.vertices()}, nullptr, nullptr, &fitted);
  const auto equal =
      fitter.Fit(UserCloud(0), {cage_.vertices(), cage_.vertices()}, nullptr, nullptr, &fitted);
  ASSERT_TRUE(first.ok() && second.ok() && equal.ok());
  EXPECT_EQ(first->start, 0);
  EXPECT_EQ(second->start, 1);
  EXPECT_EQ(equal->start, 0);
  ASSERT_TRUE(fitter.Fit(UserCloud(0), {cage_.vertices()}, nullptr, nullptr, &alone).ok());
  EXPECT_EQ(fitted, alone);
  EXPECT_FALSE(fitter.Fit(UserCloud(0), {}, nullptr, nullptr, &fitted).ok());
}

TEST_F(FitterTest, TheCeresSolverAgrees) {
  FitOptions options;
  options.solver.relative_decrease = 1e-6;
  options.solver.max_iterations = 1000;
  options.solver.first_stiffness = 1;
  options.distance.radius = 0.1 * kUserScale;
  options.arap.weight = 0.05;
  FitOptions ceres_options = options;
  ceres_options.solver.solver = Solver::kCeres;
  Points3d fitted;
  const auto newton =
      MakeFitter(options).Fit(UserCloud(0), {cage_.vertices()}, nullptr, nullptr, &fitted);
  const auto ceres =
      MakeFitter(ceres_options).Fit(UserCloud(0), {cage_.vertices()}, nullptr, nullptr, &fitted);
  ASSERT_TRUE(newton.ok() && ceres.ok());
  EXPECT_NEAR(newton->final.total(), ceres->final.total(), 1e-3 * ceres->final.total());
}

// Largest difference between the gradient of Evaluate at V and central differences, which choose
// radius, branch and feet anew, along some directions that move all vertices; relative to the
// slope.
double WorstSlope(Fitter* fitter, const PointCloud* target, const Points3d& start,
                  const Points3d& V) {
  Points3d gradient;
  EXPECT_TRUE(fitter->Evaluate(target, start, V, nullptr, &gradient).ok());
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  double worst = 0;
  for (int k = 0; k < 4; ++k) {
    const Points3d direction = Points3d::NullaryExpr(3, V.cols(), [&] { return normal(random); });
    const double step = 1e-7 * kUserScale;
    const double ahead =
        fitter->Evaluate(target, start, V + step * direction, nullptr, nullptr)->total();
    const double behind =
        fitter->Evaluate(target, start, V - step * direction, nullptr, nullptr)->total();
    const double slope = gradient.cwiseProduct(direction).sum();
    worst = std::max(worst, std::abs((ahead - behind) / (2 * step) - slope) / gradient.norm());
  }
  return worst;
}

TEST_F(FitterTest, TheGradientOfTheLossIsThatOfFreshChoicesInUserUnits) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 0.01 * kUserScale);
  const PointCloud target = UserCloud(0.05);
  for (const Field field : {Field::kImls, Field::kRimls}) {
    for (const RestMesh rest : {RestMesh::kTemplate, RestMesh::kPreviousFrame}) {
      FitOptions options;
      options.distance.field = field;
      options.arap.rest = rest;
      Fitter fitter = MakeFitter(options);
      const Points3d V = cage_.vertices() + Points3d::NullaryExpr(3, cage_.vertex_count(),
                                                                  [&] { return normal(random); });
      // The weights that RIMLS settles on are held in its gradient, and chosen anew beside it.
      EXPECT_LT(WorstSlope(&fitter, &target, cage_.vertices(), V),
                field == Field::kImls ? 1e-6 : 1e-3);
    }
  }
}

TEST_F(FitterTest, TheLossAtTheFittedVerticesIsTheEnergyOfTheFit) {
  FitOptions options;
  options.solver.relative_decrease = 1e-8;  // feet are sought as closely
  Fitter fitter = MakeFitter(options);
  Points3d fitted;
  const auto summary = fitter.Fit(UserCloud(0), {cage_.vertices()}, nullptr, nullptr, &fitted);
  ASSERT_TRUE(summary.ok()) << summary.status();
  const auto loss = fitter.Evaluate(nullptr, cage_.vertices(), fitted, nullptr, nullptr);
  ASSERT_TRUE(loss.ok()) << loss.status();
  EXPECT_NEAR(loss->distance, summary->final.distance, 1e-9 * loss->distance);
  EXPECT_NEAR(loss->arap, summary->final.arap, 1e-9 * loss->arap);
  EXPECT_NEAR(loss->coverage, summary->final.coverage, 1e-6 * loss->coverage);
}

TEST_F(FitterTest, AFitAfterALossIsTheFitWithoutIt) {
  const PointCloud first_cloud = UserCloud(0), second_cloud = UserCloud(0.05);
  Fitter asked = MakeFitter(), other = MakeFitter();
  Points3d first, first_again, second, second_again, gradient;
  const auto ask = [&](const PointCloud* target) {
    const Points3d V = cage_.vertices().array() + 3;
    ASSERT_TRUE(asked.Evaluate(target, cage_.vertices(), V, nullptr, &gradient).ok());
  };
  ask(&second_cloud);
  ASSERT_TRUE(asked.Fit(first_cloud, {cage_.vertices()}, nullptr, nullptr, &first).ok());
  ask(nullptr);
  ask(&second_cloud);
  ASSERT_TRUE(asked.Fit(second_cloud, {first}, nullptr, nullptr, &second).ok());
  ASSERT_TRUE(other.Fit(first_cloud, {cage_.vertices()}, nullptr, nullptr, &first_again).ok());
  ASSERT_TRUE(other.Fit(second_cloud, {first}, nullptr, nullptr, &second_again).ok());
  EXPECT_EQ(first, first_again);
  EXPECT_EQ(second, second_again);
}

TEST_F(FitterTest, ALossIsAPureFunctionOfItsArguments) {
  const PointCloud first = UserCloud(0), second = UserCloud(0.05);
  const Points3d V = cage_.vertices().array() + 3;
  Fitter used = MakeFitter();
  Points3d fitted, gradient, other, again, fresh;
  ASSERT_TRUE(used.Fit(first, {cage_.vertices()}, nullptr, nullptr, &fitted).ok());
  const auto at_last = used.Evaluate(nullptr, cage_.vertices(), V, nullptr, &gradient);
  ASSERT_TRUE(used.Evaluate(&second, fitted, fitted, nullptr, &other).ok());
  ASSERT_TRUE(used.Evaluate(nullptr, cage_.vertices(), V, nullptr, &again).ok());
  const auto given = MakeFitter().Evaluate(&first, cage_.vertices(), V, nullptr, &fresh);
  ASSERT_TRUE(at_last.ok() && given.ok());
  EXPECT_EQ(at_last->total(), given->total());
  EXPECT_EQ(gradient, again);
  EXPECT_EQ(gradient, fresh);
}

TEST_F(FitterTest, ALossThatCannotBeEvaluatedSaysWhy) {
  Fitter fitter = MakeFitter();
  const PointCloud target = UserCloud(0);
  const Points3d V = cage_.vertices();
  const auto error = [&](const PointCloud* cloud, const Points3d& vertices) {
    return fitter.Evaluate(cloud, V, vertices, nullptr, nullptr).status();
  };
  EXPECT_TRUE(absl::IsFailedPrecondition(error(nullptr, V)));
  EXPECT_EQ(error(&target, V.leftCols(5)).message(),
            "vertices: 5 vertices; 162 finite ones are needed");
  Points3d bad = V;
  bad(1, 17) = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(absl::IsInvalidArgument(error(&target, bad)));
  bad(1, 17) = 1e300;
  EXPECT_TRUE(absl::IsInvalidArgument(error(&target, bad)));
  PointCloud bare = target;
  bare.normals.resize(3, 0);
  EXPECT_EQ(error(&bare, V).message(), "target: it has no normals");
  EXPECT_TRUE(absl::IsCancelled(fitter
                                    .Evaluate(
                                        &target, V, V, [] { return true; }, nullptr)
                                    .status()));
}

TEST_F(FitterTest, ALossIsFiniteWhereverVerticesMayBe) {
  Fitter fitter = MakeFitter();
  const PointCloud target = UserCloud(0);
  Points3d V = cage_.vertices(), gradient;
  for (const double scale : {0.0, 1e-9, 1e5}) {
    const Points3d scaled = scale * V;
    const auto loss = fitter.Evaluate(&target, V, scaled, nullptr, &gradient);
    ASSERT_TRUE(loss.ok()) << loss.status();
    EXPECT_TRUE(std::isfinite(loss->total())) << scale;
    EXPECT_TRUE(gradient.allFinite()) << scale;
  }
}

TEST_F(FitterTest, OptionsOutOfRangeAreNamed) {
  FitOptions options;
  options.distance.radius_factor = 0.1;
  const absl::Status status = Fitter::Create(cage_, normalization_, options).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_NE(status.message().find("radius_factor is 0.1"), std::string::npos);
}

TEST(NormalizationTest, PutsTheBoxIntoTheUnitBoxAndBack) {
  Box box;
  box.min = Eigen::Vector3d(1, 2, 3);
  box.max = Eigen::Vector3d(5, 4, 4);
  const Normalization normalization = *Normalization::FromBox(box);
  Points3d corners(3, 2);
  corners << 1, 5, 2, 4, 3, 4;
  const Points3d unit = normalization.ToUnit(corners);
  EXPECT_NEAR((unit.col(1) - Eigen::Vector3d(0.5, 0.25, 0.125)).norm(), 0, 1e-15);
  EXPECT_NEAR((normalization.ToUser(unit) - corners).norm(), 0, 1e-14);
  EXPECT_EQ(Normalization::FromBox(Box()).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace cagefit
