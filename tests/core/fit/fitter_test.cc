#include "core/fit/fitter.h"

#include <gtest/gtest.h>

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
