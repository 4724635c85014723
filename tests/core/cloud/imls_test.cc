#include "core/cloud/imls.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/core/cloud/sphere_cloud.h"

namespace cagefit {
namespace {

// The formula of the header, term by term.
double NaiveImls(const PointCloud& cloud, const Eigen::Vector3d& x, double h) {
  double sum = 0, weights = 0;
  for (int64_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d d = x - cloud.points.col(i).cast<double>();
    if (d.norm() >= h) continue;
    const double phi = std::pow(1 - d.squaredNorm() / (h * h), 4);
    weights += phi;
    sum += phi * cloud.normals.col(i).normalized().cast<double>().dot(d);
  }
  return sum / weights;
}

TEST(ImlsTest, EqualsTheFormula) {
  const PointCloud cloud = testing::SphereCloud(3000);
  CellGrid grid;
  grid.Build(cloud, 0.2);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int q = 0; q < 200; ++q) {
    const Eigen::Vector3d direction =
        Eigen::Vector3d(uniform(random), uniform(random), uniform(random)).normalized();
    const Eigen::Vector3d x = direction * (1 + 0.08 * uniform(random));
    for (const double h : {0.1, 0.2, 0.55}) {
      const ImlsValue f = EvaluateImls(grid, x, h);
      ASSERT_GT(f.support, 0);
      EXPECT_NEAR(f.value, NaiveImls(cloud, x, h), 1e-6 * h);
    }
  }
}

TEST(ImlsTest, GradientAgreesWithFiniteDifferences) {
  CellGrid grid;
  grid.Build(testing::SphereCloud(3000), 0.2);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int q = 0; q < 100; ++q) {
    const Eigen::Vector3d x =
        Eigen::Vector3d(uniform(random), uniform(random), uniform(random)).normalized() *
        (1 + 0.1 * uniform(random));
    const double h = 0.12 + 0.3 * std::abs(uniform(random));
    const ImlsValue f = EvaluateImls(grid, x, h);
    ASSERT_GT(f.support, 0);
    for (int axis = 0; axis < 3; ++axis) {
      const double step = 1e-5;
      const Eigen::Vector3d e = step * Eigen::Vector3d::Unit(axis);
      const double difference =
          (EvaluateImls(grid, x + e, h).value - EvaluateImls(grid, x - e, h).value) / (2 * step);
      EXPECT_NEAR(f.gradient[axis], difference, 1e-6);
    }
  }
}

TEST(ImlsTest, IsExactOnAPlane) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-1, 1);
  PointCloud cloud;
  cloud.points.resize(3, 4000);
  for (int64_t i = 0; i < 4000; ++i) cloud.points.col(i) << uniform(random), uniform(random), 0;
  cloud.normals = Eigen::Vector3f::UnitZ().replicate(1, 4000);
  CellGrid grid;
  grid.Build(cloud, 0.2);
  const ImlsValue f = EvaluateImls(grid, Eigen::Vector3d(0.1, -0.2, 0.03), 0.1);
  EXPECT_NEAR(f.value, 0.03, 1e-12);
  EXPECT_NEAR((f.gradient - Eigen::Vector3d::UnitZ()).norm(), 0, 1e-10);
  EXPECT_GE(f.nearest, 0.03);
}

TEST(ImlsTest, ReportsNoSupportBeyondTheRadius) {
  CellGrid grid;
  grid.Build(testing::SphereCloud(500), 0.2);
  EXPECT_EQ(EvaluateImls(grid, Eigen::Vector3d(2, 0, 0), 0.5).support, 0);
  EXPECT_EQ(EvaluateImls(grid, Eigen::Vector3d(1e9, 0, 0), 0.5).support, 0);
}

TEST(ImlsTest, NearestIsTheDistanceToTheNearestPoint) {
  const PointCloud cloud = testing::SphereCloud(500);
  CellGrid grid;
  grid.Build(cloud, 0.3);
  const Eigen::Vector3d x(0.3, 0.9, -0.4);
  const double nearest = (cloud.points.cast<double>().colwise() - x).colwise().norm().minCoeff();
  EXPECT_NEAR(EvaluateImls(grid, x, 0.4).nearest, nearest, 1e-9);
}

}  // namespace
}  // namespace cagefit
