#include "core/cloud/rimls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "core/base/random.h"
#include "tests/core/cloud/sphere_cloud.h"

namespace cagefit {
namespace {

// Uniform on the square [-1, 1]^2 in z = 0, normals +z.
PointCloud PlaneCloud(int64_t count) {
  Random random(3);
  PointCloud cloud;
  cloud.points.resize(3, count);
  for (int64_t i = 0; i < count; ++i) {
    cloud.points.col(i) =
        Eigen::Vector3d(random.Uniform(-1, 1), random.Uniform(-1, 1), 0).cast<float>();
  }
  cloud.normals = Eigen::Vector3f::UnitZ().replicate(1, count);
  return cloud;
}

// The faces of the cube [-1, 1]^3 as `cells` x `cells` points each, normals those of the faces.
PointCloud CubeCloud(int cells) {
  PointCloud cloud;
  cloud.points.resize(3, 6 * cells * cells);
  cloud.normals.resize(3, cloud.size());
  int64_t k = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const float side : {-1.0f, 1.0f}) {
      for (int i = 0; i < cells * cells; ++i, ++k) {
        const auto at = [&](int cell) { return 2 * (static_cast<float>(cell) + 0.5f) / cells - 1; };
        cloud.points(axis, k) = side;
        cloud.points((axis + 1) % 3, k) = at(i / cells);
        cloud.points((axis + 2) % 3, k) = at(i % cells);
        cloud.normals.col(k) = side * Eigen::Vector3f::Unit(axis);
      }
    }
  }
  return cloud;
}

CellGrid GridOf(const PointCloud& cloud, double h) {
  CellGrid grid;
  grid.Build(cloud, h);
  return grid;
}

double Rimls(const CellGrid& grid, const Eigen::Vector3d& x, double h) {
  return EvaluateRimls(grid, x, h, {}, SolveRimls(grid, x, h, {})).value;
}

// The formula of the header, term by term.
double NaiveRimls(const PointCloud& cloud, const Eigen::Vector3d& x, double h, double normal_sigma,
                  const RimlsReference& reference) {
  double sum = 0, weights = 0;
  const double sigma_r = 0.5 * h;
  for (int64_t k = 0; k < cloud.size(); ++k) {
    const Eigen::Vector3d d = x - cloud.points.col(k).cast<double>();
    const Eigen::Vector3d n = cloud.normals.col(k).normalized().cast<double>();
    if (d.norm() >= h) continue;
    const double c = n.dot(d);
    const double W = std::pow(1 - d.squaredNorm() / (h * h), 4) *
                     std::exp(-std::pow((c - reference.value) / sigma_r, 2)) *
                     std::exp(-(n - reference.gradient).squaredNorm() / std::pow(normal_sigma, 2));
    weights += W;
    sum += W * c;
  }
  return sum / weights;
}

Eigen::Vector3d NearUnitSphere(Random* random, double margin) {
  return random->NormalVector().normalized() * (1 + random->Uniform(-margin, margin));
}

TEST(RimlsTest, EqualsTheFormula) {
  const PointCloud cloud = testing::SphereCloud(3000);
  const CellGrid grid = GridOf(cloud, 0.2);
  Random random(1);
  for (int q = 0; q < 100; ++q) {
    const Eigen::Vector3d x = NearUnitSphere(&random, 0.08);
    for (const double h : {0.12, 0.2, 0.55}) {
      for (const double normal_sigma : {0.5, 0.8, 1.5}) {
        RimlsOptions options;
        options.normal_sigma = normal_sigma;
        const RimlsReference reference = {random.Uniform(-0.3, 0.3) * h,
                                          0.9 * random.NormalVector().normalized()};
        const ImlsValue f = EvaluateRimls(grid, x, h, options, reference);
        ASSERT_GT(f.support, 0);
        EXPECT_NEAR(f.value, NaiveRimls(cloud, x, h, normal_sigma, reference), 1e-6 * h);
      }
    }
  }
}

TEST(RimlsTest, GradientAtAHeldReferenceAgreesWithFiniteDifferences) {
  for (const PointCloud& cloud : {testing::SphereCloud(3000), CubeCloud(40)}) {
    const CellGrid grid = GridOf(cloud, 0.2);
    Random random(2);
    for (int q = 0; q < 100; ++q) {
      const Eigen::Vector3d at = cloud.points.col((997 * q) % cloud.size()).cast<double>();
      const Eigen::Vector3d x = at + 0.04 * random.NormalVector();
      const double h = random.Uniform(0.25, 0.45);
      const RimlsReference reference = SolveRimls(grid, x, h, {});
      const ImlsValue f = EvaluateRimls(grid, x, h, {}, reference);
      ASSERT_GT(f.support, 0);
      for (int axis = 0; axis < 3; ++axis) {
        const double step = 1e-5;
        const Eigen::Vector3d e = step * Eigen::Vector3d::Unit(axis);
        const double difference = (EvaluateRimls(grid, x + e, h, {}, reference).value -
                                   EvaluateRimls(grid, x - e, h, {}, reference).value) /
                                  (2 * step);
        EXPECT_NEAR(f.gradient[axis], difference, 1e-6);
      }
    }
  }
}

TEST(RimlsTest, IsExactOnAPlane) {
  const CellGrid grid = GridOf(PlaneCloud(4000), 0.2);
  const Eigen::Vector3d x(0.1, -0.2, 0.03);
  const RimlsReference reference = SolveRimls(grid, x, 0.1, {});
  EXPECT_NEAR(reference.value, 0.03, 1e-12);
  EXPECT_NEAR((reference.gradient - Eigen::Vector3d::UnitZ()).norm(), 0, 1e-10);
  const ImlsValue f = EvaluateRimls(grid, x, 0.1, {}, reference);
  EXPECT_NEAR(f.value, 0.03, 1e-12);
  EXPECT_NEAR(f.value, EvaluateImls(grid, x, 0.1).value, 1e-12);
  EXPECT_NEAR((f.gradient - Eigen::Vector3d::UnitZ()).norm(), 0, 1e-10);
}

TEST(RimlsTest, IsTheDistanceToASphereButForItsCurvature) {
  const CellGrid grid = GridOf(testing::SphereCloud(20000), 0.1);
  Random random(4);
  for (const double h : {0.1, 0.2}) {
    for (int q = 0; q < 100; ++q) {
      const Eigen::Vector3d x = NearUnitSphere(&random, 0.3 * h);
      // A point at r from the foot has its plane r^2/2 off at curvature 1.
      EXPECT_NEAR(Rimls(grid, x, h), x.norm() - 1, h * h / 2);
    }
  }
}

// On the surface near an edge the planes of both faces blend in IMLS.
TEST(RimlsTest, KeepsTheEdgeOfACubeThatImlsRounds) {
  const CellGrid grid = GridOf(CubeCloud(100), 0.1);
  const double h = 0.1;
  double imls = 0, rimls = 0;
  for (double along = -0.5; along < 0.5; along += 0.013) {
    for (const double inward : {0.2, 0.3, 0.5}) {  // in radii
      const Eigen::Vector3d x(1, 1 - inward * h, along);
      imls = std::max(imls, std::abs(EvaluateImls(grid, x, h).value));
      rimls = std::max(rimls, std::abs(Rimls(grid, x, h)));
    }
  }
  EXPECT_GT(imls, 0.05 * h);
  EXPECT_LT(rimls, 0.25 * imls);
}

TEST(RimlsTest, ASmallerSigmaOfNormalsIsSharper) {
  const CellGrid grid = GridOf(CubeCloud(100), 0.1);
  const double h = 0.1;
  const Eigen::Vector3d x(1, 1 - 0.3 * h, 0.2);
  double before = 0;
  for (const double normal_sigma : {0.5, 0.8, 1.5}) {
    RimlsOptions options;
    options.normal_sigma = normal_sigma;
    const double off =
        std::abs(EvaluateRimls(grid, x, h, options, SolveRimls(grid, x, h, options)).value);
    EXPECT_GT(off, before);
    before = off;
  }
  EXPECT_LT(before, std::abs(EvaluateImls(grid, x, h).value));
}

// One point in ten lifted off a plane, or with its normal turned away.
TEST(RimlsTest, OutliersCountLittle) {
  const double h = 0.1;
  const auto largest_error = [&](const PointCloud& cloud, bool robust) {
    const CellGrid grid = GridOf(cloud, h);
    Random random(5);
    double largest = 0;
    for (int q = 0; q < 200; ++q) {
      const double z = random.Uniform(-0.1, 0.1) * h;
      const Eigen::Vector3d x(random.Uniform(-0.8, 0.8), random.Uniform(-0.8, 0.8), z);
      const double f = robust ? Rimls(grid, x, h) : EvaluateImls(grid, x, h).value;
      largest = std::max(largest, std::abs(f - z));
    }
    return largest;
  };
  PointCloud lifted = PlaneCloud(20000), turned = lifted;
  Random random(6);
  for (int64_t i = 0; i < lifted.size(); i += 10) {
    lifted.points(2, i) = static_cast<float>(0.7 * h);
    turned.normals.col(i) = (Eigen::Vector3d::UnitX() + 0.1 * random.NormalVector()).cast<float>();
    turned.normals.col(i).normalize();
  }
  for (const PointCloud* cloud : {&lifted, &turned}) {
    const double imls = largest_error(*cloud, false);
    EXPECT_GT(imls, 0.01 * h);
    EXPECT_LT(largest_error(*cloud, true), 0.5 * imls);
  }
}

TEST(RimlsTest, ReferenceIsZeroWhereNoPointIsWithinTheRadius) {
  const CellGrid grid = GridOf(testing::SphereCloud(500), 0.2);
  const Eigen::Vector3d x(2, 0, 0);
  const RimlsReference reference = SolveRimls(grid, x, 0.5, {});
  EXPECT_EQ(reference.value, 0);
  EXPECT_EQ(reference.gradient, Eigen::Vector3d::Zero());
  EXPECT_EQ(EvaluateRimls(grid, x, 0.5, {}, reference).support, 0);
}

TEST(RimlsTest, GradientOfTheReferenceIsNoLongerThanOne) {
  const CellGrid grid = GridOf(CubeCloud(40), 0.2);
  Random random(7);
  for (int q = 0; q < 300; ++q) {
    const Eigen::Vector3d x = Eigen::Vector3d(1, 1, 1) + 0.1 * random.NormalVector();
    EXPECT_LE(SolveRimls(grid, x, 0.3, {}).gradient.norm(), 1 + 1e-12);
  }
}

TEST(RimlsTest, SupportAndNearestAreThoseOfImls) {
  const CellGrid grid = GridOf(CubeCloud(40), 0.2);
  Random random(8);
  for (int q = 0; q < 100; ++q) {
    const Eigen::Vector3d x = Eigen::Vector3d(1, 0.9, 0.2) + 0.05 * random.NormalVector();
    const ImlsValue plain = EvaluateImls(grid, x, 0.25);
    const ImlsValue robust = EvaluateRimls(grid, x, 0.25, {}, SolveRimls(grid, x, 0.25, {}));
    EXPECT_EQ(robust.support, plain.support);
    EXPECT_NEAR(robust.nearest, plain.nearest, 1e-12);
  }
}

}  // namespace
}  // namespace cagefit
