#include "core/energy/distance_term.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace cagefit {
namespace {

// An even disk of radius 0.5 in the plane z = 0, normal +z (sunflower arrangement).
PointCloud DiskCloud(int64_t count) {
  PointCloud cloud;
  cloud.points.resize(3, count);
  for (int64_t i = 0; i < count; ++i) {
    const double r = 0.5 * std::sqrt((static_cast<double>(i) + 0.5) / static_cast<double>(count));
    const double a = 2.399963229728653 * static_cast<double>(i);
    cloud.points.col(i) = Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0).cast<float>();
  }
  cloud.normals = Eigen::Vector3f::UnitZ().replicate(1, count);
  return cloud;
}

// A sphere of radius 0.4 whose upper half is sampled 16 times more densely, so that radii grow
// below.
PointCloud UnevenSphere(int64_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform;
  PointCloud cloud;
  cloud.points.resize(3, count);
  cloud.normals.resize(3, count);
  for (int64_t i = 0; i < count;) {
    const Eigen::Vector3f n =
        Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
    if (n.z() < 0 && uniform(random) > 1.0f / 16) continue;
    cloud.points.col(i) = 0.4f * n;
    cloud.normals.col(i++) = n;
  }
  return cloud;
}

// Beside a sphere of radius 0.4: two of three within 0.05, the others within `margin`.
Points3d AroundTheSphere(int64_t count, double margin) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Points3d Q(3, count);
  for (int64_t i = 0; i < count; ++i) {
    const Eigen::Vector3d n =
        Eigen::Vector3d(uniform(random), uniform(random), uniform(random)).normalized();
    Q.col(i) = n * (0.4 + (i % 3 == 0 ? margin : std::min(margin, 0.05)) * uniform(random));
  }
  return Q;
}

class DistanceTermTest : public ::testing::Test {
 protected:
  void Use(PointCloud cloud, double radius, double far_radius, Field field = Field::kImls,
           const RobustKernel& kernel = {}) {
    cloud_ = std::move(cloud);
    ASSERT_TRUE(index_.Build(cloud_, radius, 2).ok());
    term_.SetTarget(&index_, far_radius, 10, field, kernel);
  }

  double EnergyAt(const Eigen::Vector3d& x) {
    residuals_.clear();
    return term_.Assign(x, &residuals_);
  }

  // Assigns samples in every branch.
  void AssignEverywhere(const Points3d& Q) {
    residuals_.clear();
    term_.Assign(Q, &residuals_);
    ASSERT_GT(term_.grown_samples(), Q.cols() / 12);
    ASSERT_GT(term_.far_samples(), Q.cols() / 12);
    ASSERT_LT(term_.grown_samples() + term_.far_samples(), Q.cols() * 11 / 12);
  }

  // Of sample i, at x, under what Assign chose.
  void ExpectExactGradients(int64_t i, const Eigen::Vector3d& x) {
    const SampleResiduals r = term_.EvaluateSample(i, x);
    for (int axis = 0; axis < 3; ++axis) {
      const double step = 1e-6;
      const Eigen::Vector3d e = step * Eigen::Vector3d::Unit(axis);
      const SampleResiduals ahead = term_.EvaluateSample(i, x + e);
      const SampleResiduals behind = term_.EvaluateSample(i, x - e);
      EXPECT_NEAR(r.grad_f[axis], (ahead.f - behind.f) / (2 * step), 1e-6) << "sample " << i;
      EXPECT_NEAR(r.grad_beyond[axis], (ahead.beyond - behind.beyond) / (2 * step), 1e-6)
          << "sample " << i;
    }
  }

  PointCloud cloud_;
  TargetIndex index_;
  DistanceTerm term_;
  std::vector<SampleResiduals> residuals_;
};

TEST_F(DistanceTermTest, WeighsSamplesByControlVerticesOverSamples) {
  Use(DiskCloud(4000), 0, 0.2);
  Points3d Q(3, 2);
  Q << 0, 0.1, 0, 0.1, 0.01, 0.02;
  EXPECT_NEAR(term_.Assign(Q, &residuals_), 10.0 / 2 * (0.01 * 0.01 + 0.02 * 0.02), 1e-12);
}

TEST_F(DistanceTermTest, GradientsAgreeWithFiniteDifferencesInEveryBranch) {
  for (const Field field : {Field::kImls, Field::kRimls}) {
    Use(UnevenSphere(20000, 1), 0.02, 0.06, field);
    const Points3d Q = AroundTheSphere(600, 0.3);
    AssignEverywhere(Q);
    for (int64_t i = 0; i < Q.cols(); ++i) ExpectExactGradients(i, Q.col(i));
  }
}

TEST_F(DistanceTermTest, GradientsAgreeWithFiniteDifferencesInACoarseProblem) {
  for (const double factor : {2.0, 4.0}) {
    Use(UnevenSphere(20000, 1), 0.01, 0.03);
    term_.SetCoarseness(factor, 1);
    const Points3d Q = AroundTheSphere(400, 0.3);
    AssignEverywhere(Q);
    double farthest = 0;
    for (int64_t i = 0; i < Q.cols(); ++i) {
      ExpectExactGradients(i, Q.col(i));
      if (residuals_[i].support > 0) farthest = std::max(farthest, std::abs(residuals_[i].f));
    }
    EXPECT_GT(farthest, 0.015 * factor);  // the far radius is larger, too
    EXPECT_LT(farthest, 0.03 * factor * 1.1);
  }
}

// Steps lead samples to where they would be far.
TEST_F(DistanceTermTest, GradientsAgreeWithFiniteDifferencesInAHeldFieldBeyondTheFarRadius) {
  for (const Field field : {Field::kImls, Field::kRimls}) {
    Use(UnevenSphere(20000, 1), 0.2, 0.05, field);
    const Points3d Q = AroundTheSphere(100, 0.03);
    residuals_.clear();
    term_.Assign(Q, &residuals_);
    ASSERT_EQ(term_.far_samples(), 0);
    for (int64_t i = 0; i < Q.cols(); ++i) {
      const Eigen::Vector3d x = 0.5 * Q.col(i).normalized();
      const SampleResiduals r = term_.EvaluateSample(i, x);
      EXPECT_GT(r.support, 0);
      EXPECT_NEAR(r.beyond, 0.05, 0.01);
      ExpectExactGradients(i, x);
    }
  }
}

// dE/dQ_i = 2 n/m (rho' f grad f + beyond grad beyond).
TEST_F(DistanceTermTest, GradientOfTheEnergyAgreesWithFiniteDifferencesUnderEveryKernel) {
  const PointCloud cloud = UnevenSphere(20000, 1);
  for (const Kernel kernel :
       {Kernel::kIdentity, Kernel::kHuber, Kernel::kGemanMcClure, Kernel::kTukey}) {
    for (const double kernel_factor : {1.0, 3.0}) {
      Use(cloud, 0.02, 0.06, Field::kImls, {kernel, 0.02});
      term_.SetCoarseness(1, kernel_factor);
      EXPECT_DOUBLE_EQ(term_.kernel().scale, 0.02 * kernel_factor);
      Points3d Q = AroundTheSphere(60, 0.15);
      AssignEverywhere(Q);
      term_.Evaluate(Q, &residuals_);
      std::vector<Eigen::Vector3d> gradient;
      double scale = 0;
      for (const SampleResiduals& r : residuals_) {
        gradient.push_back(2 * term_.weight() *
                           (r.weight * r.f * r.grad_f + r.beyond * r.grad_beyond));
        scale = std::max(scale, gradient.back().norm());
      }
      for (int64_t i = 0; i < Q.cols(); ++i) {
        for (int axis = 0; axis < 3; ++axis) {
          const double step = 1e-6, at = Q(axis, i);
          Q(axis, i) = at + step;
          const double ahead = term_.Evaluate(Q, &residuals_);
          Q(axis, i) = at - step;
          const double behind = term_.Evaluate(Q, &residuals_);
          Q(axis, i) = at;
          EXPECT_NEAR(gradient[i][axis], (ahead - behind) / (2 * step), 1e-6 * scale)
              << "sample " << i << ", kernel " << static_cast<int>(kernel);
        }
      }
    }
  }
}

TEST_F(DistanceTermTest, ASampleThatLeavesAnOpenDiskNeverGainsBeyondTheFarRadius) {
  Use(DiskCloud(4000), 0, 0.1);
  for (const double elevation : {0.0, 0.02, 0.3, 0.8, 1.2, 1.57}) {  // rad, above the disk's plane
    for (const double azimuth : {0.0, 0.7, 2.0, 4.1}) {
      const Eigen::Vector3d rim(0.5 * std::cos(azimuth), 0.5 * std::sin(azimuth), 0);
      const Eigen::Vector3d direction =
          std::cos(elevation) * rim.normalized() + std::sin(elevation) * Eigen::Vector3d::UnitZ();
      double before = 0;
      for (double d = 0.1; d < 3; d += 0.01) {
        const double energy = EnergyAt(rim + d * direction);
        EXPECT_GE(energy, before * (1 - 1e-12)) << "elevation " << elevation << ", distance " << d;
        before = energy;
      }
      EXPECT_GT(before, 10 * 2.5 * 2.5);
    }
  }
}

TEST_F(DistanceTermTest, HoldsRadiusAndBranchUntilAssignedAnew) {
  Use(DiskCloud(4000), 0.03, 0.1);
  Points3d Q(3, 1);
  Q << 0, 0, 0.5;  // far
  term_.Assign(Q, &residuals_);
  ASSERT_EQ(term_.far_samples(), 1);
  Q << 0.1, 0, 0.001;  // near: still measured against the held nearest point
  const double held = term_.Evaluate(Q, &residuals_);
  EXPECT_EQ(term_.far_samples(), 1);
  const double anew = term_.Assign(Q, &residuals_);
  EXPECT_EQ(term_.far_samples(), 0);
  EXPECT_NEAR(anew, 10 * 0.001 * 0.001, 1e-9);
  EXPECT_NEAR(held, 10 * 0.001 * 0.001, 1e-9);  // the plane is the same here
}

TEST_F(DistanceTermTest, ATrialStepOutOfItsSupportKeepsAFiniteEnergy) {
  Use(DiskCloud(4000), 0.03, 0.1);
  Points3d Q(3, 1);
  Q << 0, 0, 0.01;
  term_.Assign(Q, &residuals_);
  Q << 0, 0, 5;
  EXPECT_NEAR(term_.Evaluate(Q, &residuals_), 10 * (5 * 5 + 4.9 * 4.9), 1e-3);
}

}  // namespace
}  // namespace cagefit
