#include "core/template/poisson.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/mesh/topology.h"

namespace cagefit {
namespace {

// Points of the unit sphere with z above `least_z`.
PointCloud SphereCloud(int64_t count, double least_z, int outliers = 0) {
  std::mt19937 random(3);
  const auto uniform = [&] { return random() / 4294967296.0; };
  PointCloud cloud;
  cloud.points.resize(3, count);
  cloud.normals.resize(3, count);
  for (int64_t i = 0; i < count; ++i) {
    const double z = least_z + (1 - least_z) * uniform(), a = 2 * M_PI * uniform();
    const double r = std::sqrt(1 - z * z);
    const Eigen::Vector3f n = Eigen::Vector3d(r * std::cos(a), r * std::sin(a), z).cast<float>();
    cloud.normals.col(i) = n;
    cloud.points.col(i) = i < outliers ? (n * (1.3f + 0.1f * static_cast<float>(i))).eval() : n;
  }
  return cloud;
}

TEST(PoissonTest, AClosedCloudGivesAClosedSurface) {
  const auto mesh = ReconstructPoisson(SphereCloud(20'000, -1), 300);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  const auto topology =
      Topology::Create(static_cast<int32_t>(mesh->vertices.cols()), mesh->triangles);
  ASSERT_TRUE(topology.ok()) << topology.status();
  EXPECT_TRUE(topology->BoundaryLoops().empty());
  EXPECT_NEAR(mesh->vertices.colwise().norm().mean(), 1, 5e-3);
}

TEST(PoissonTest, AnOpenCloudStaysOpenAtItsRim) {
  const auto mesh = ReconstructPoisson(SphereCloud(20'000, 0), 300);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  const auto topology =
      Topology::Create(static_cast<int32_t>(mesh->vertices.cols()), mesh->triangles);
  ASSERT_TRUE(topology.ok()) << topology.status();
  const std::vector<std::vector<int32_t>> loops = topology->BoundaryLoops();
  ASSERT_EQ(loops.size(), 1u);
  for (const int32_t v : loops[0]) {
    EXPECT_NEAR(mesh->vertices(2, v), 0, 0.08);
  }
}

TEST(PoissonTest, OutliersGrowNothing) {
  const auto mesh = ReconstructPoisson(SphereCloud(20'000, -1, 10), 300);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_LT(mesh->vertices.colwise().norm().maxCoeff(), 1.1);
}

TEST(PoissonTest, SaysWhatItNeeds) {
  PointCloud bare = SphereCloud(100, -1);
  bare.normals.resize(3, 0);
  EXPECT_EQ(ReconstructPoisson(bare, 300).status().code(), absl::StatusCode::kInvalidArgument);
  PointCloud same = SphereCloud(100, -1);
  same.points.colwise() = Eigen::Vector3f(1, 2, 3);
  EXPECT_EQ(ReconstructPoisson(same, 300).status().code(), absl::StatusCode::kFailedPrecondition);
}

}  // namespace
}  // namespace cagefit
