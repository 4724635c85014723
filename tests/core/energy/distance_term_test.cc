#include "core/energy/distance_term.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

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

class DistanceTermTest : public ::testing::Test {
 protected:
  void Use(PointCloud cloud, double radius, double far_radius) {
    cloud_ = std::move(cloud);
    ASSERT_TRUE(index_.Build(cloud_, radius, 2).ok());
    term_.SetTarget(&index_, far_radius, 10);
  }

  double EnergyAt(const Eigen::Vector3d& x) {
    residuals_.clear();
    return term_.Assign(x, &residuals_);
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
  Use(UnevenSphere(20000, 1), 0.02, 0.06);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Points3d Q(3, 600);
  for (int64_t i = 0; i < Q.cols(); ++i) {
    const Eigen::Vector3d n =
        Eigen::Vector3d(uniform(random), uniform(random), uniform(random)).normalized();
    Q.col(i) = n * (0.4 + (i % 3 == 0 ? 0.3 : 0.05) * uniform(random));
  }
  term_.Assign(Q, &residuals_);
  ASSERT_GT(term_.grown_samples(), 50);
  ASSERT_GT(term_.far_samples(), 50);
  ASSERT_LT(term_.grown_samples() + term_.far_samples(), 550);
  for (int64_t i = 0; i < Q.cols(); ++i) {
    const SampleResiduals r = term_.EvaluateSample(i, Q.col(i));
    for (int axis = 0; axis < 3; ++axis) {
      const double step = 1e-6;
      const Eigen::Vector3d e = step * Eigen::Vector3d::Unit(axis);
      const SampleResiduals ahead = term_.EvaluateSample(i, Q.col(i) + e);
      const SampleResiduals behind = term_.EvaluateSample(i, Q.col(i) - e);
      EXPECT_NEAR(r.grad_f[axis], (ahead.f - behind.f) / (2 * step), 1e-6) << "sample " << i;
      EXPECT_NEAR(r.grad_beyond[axis], (ahead.beyond - behind.beyond) / (2 * step), 1e-6)
          << "sample " << i;
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
