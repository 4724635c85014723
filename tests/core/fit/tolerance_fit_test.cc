#include "core/fit/tolerance_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "tests/core/fit/fit_fixture.h"

namespace cagefit {
namespace {

using testing::EllipsoidCloud;
using testing::SphereCage;

// An ellipsoid with a bump that a coarse cage cannot follow, on one side only.
PointCloud BumpyCloud(int64_t count) {
  PointCloud cloud = EllipsoidCloud(count, {0.5, 0.4, 0.3});
  const Eigen::Vector3d top(0, 0, 0.3);
  for (int64_t i = 0; i < count; ++i) {
    const Eigen::Vector3d x = cloud.points.col(i).cast<double>();
    const Eigen::Vector3d n = cloud.normals.col(i).cast<double>();
    // x + b(x) e_z with b = A exp(-|x - top|^2 / w^2) and normals of the moved surface.
    const double A = 0.06, w2 = 0.01, b = A * std::exp(-(x - top).squaredNorm() / w2);
    const Eigen::Vector3d gradient = -2 / w2 * b * (x - top);
    // F = I + e_z gradient^T; the normal is F^-T n, F^-T = I - gradient e_z^T / (1 + gradient_z).
    const Eigen::Vector3d moved = n - gradient * (n.z() / (1 + gradient.z()));
    cloud.points.col(i) = (x + Eigen::Vector3d(0, 0, b)).cast<float>();
    cloud.normals.col(i) = moved.normalized().cast<float>();
  }
  return cloud;
}

PointCloud Noisy(PointCloud cloud, double sigma) {
  std::mt19937 random(11);
  std::normal_distribution<float> noise(0, static_cast<float>(sigma));
  for (int64_t i = 0; i < cloud.size(); ++i)
    cloud.points.col(i) += noise(random) * cloud.normals.col(i);
  return cloud;
}

double Diagonal(const PointCloud& cloud) { return BoundingBox(cloud.points).diagonal(); }

ToleranceFit Fit(const ControlMesh& start, const PointCloud& target, double tolerance,
                 int32_t max_vertices = 0) {
  auto fit = FitToTolerance(start, target, {tolerance, max_vertices}, FitOptions(), nullptr);
  EXPECT_TRUE(fit.ok()) << fit.status();
  return *std::move(fit);
}

TEST(ToleranceFitTest, ReachesTheTolerance) {
  const PointCloud cloud = BumpyCloud(20'000);
  const ToleranceFit fit = Fit(SphereCage(1, 0.45), cloud, 1e-3);
  EXPECT_EQ(fit.end, ToleranceEnd::kWithin);
  EXPECT_GT(fit.rounds, 1);
  EXPECT_GT(fit.mesh.vertex_count(), 42);
  EXPECT_LT(fit.mesh.vertex_count(), 1000);
  EXPECT_LE(fit.distances.most, 1e-3 * Diagonal(cloud));
  // What it says is so: counted afresh.
  const TargetDistances d = DistancesToFit(fit.mesh.WithVertices(fit.fitted), cloud.points);
  int beyond = 0;
  for (const double distance : d.distance) beyond += distance > 1e-3 * Diagonal(cloud);
  EXPECT_LE(beyond, 20);
}

TEST(ToleranceFitTest, AFitFromItsMeshIsItsFit) {
  const PointCloud cloud = BumpyCloud(20'000);
  const ToleranceFit fit = Fit(SphereCage(1, 0.45), cloud, 2e-3);
  Fitter fitter =
      Fitter::Create(fit.mesh, *Normalization::FromBox(BoundingBox(cloud.points)), FitOptions())
          .value();
  Points3d fitted;
  ASSERT_TRUE(fitter.Fit(cloud, {fit.mesh.vertices()}, nullptr, nullptr, &fitted).ok());
  EXPECT_EQ(fitted, fit.fitted);
}

TEST(ToleranceFitTest, PutsVerticesWhereTheTargetNeedsThem) {
  const ToleranceFit fit = Fit(SphereCage(1, 0.45), BumpyCloud(20'000), 3e-4);
  int top = 0, bottom = 0;
  for (int32_t v = 0; v < fit.fitted.cols(); ++v) {
    const Eigen::Vector3d x = fit.fitted.col(v);
    if (x.head<2>().norm() > 0.2) continue;
    ++(x.z() > 0 ? top : bottom);
  }
  EXPECT_GT(top, 3 * bottom);
}

TEST(ToleranceFitTest, AStartThatIsWithinStaysAsItIs) {
  const ControlMesh cage = SphereCage(3, 0.45);
  const ToleranceFit fit = Fit(cage, EllipsoidCloud(8000, {0.5, 0.4, 0.3}), 0.01);
  EXPECT_EQ(fit.end, ToleranceEnd::kWithin);
  EXPECT_EQ(fit.rounds, 1);
  EXPECT_EQ(fit.mesh.vertices(), cage.vertices());
}

TEST(ToleranceFitTest, StopsAtTheLimitOfVertices) {
  const ToleranceFit fit = Fit(SphereCage(1, 0.45), BumpyCloud(20'000), 1e-4, 100);
  EXPECT_EQ(fit.end, ToleranceEnd::kVertexLimit);
  EXPECT_EQ(fit.mesh.vertex_count(), 100);
  EXPECT_GT(fit.distances.most, 0);
}

TEST(ToleranceFitTest, StopsAtTheNoiseOfTheTarget) {
  const PointCloud cloud = Noisy(BumpyCloud(20'000), 0.003);
  const ToleranceFit fit = Fit(SphereCage(1, 0.45), cloud, 1e-3);
  EXPECT_EQ(fit.end, ToleranceEnd::kNoFurther);
  EXPECT_LT(fit.mesh.vertex_count(), 2000) << "it does not follow the noise";
  EXPECT_NEAR(fit.distances.rms, 0.003, 0.0005);
}

TEST(ToleranceFitTest, BoundaryLoopsStay) {
  // A bowl: the bottom of the ellipsoid, from a disk that reaches beyond its rim.
  const PointCloud all = EllipsoidCloud(60'000, {0.5, 0.4, 0.3});
  PointCloud bowl;
  bowl.points = all.points.rightCols(15'000);
  bowl.normals = all.normals.rightCols(15'000);
  TriangleMesh disk = testing::OpenDisk(2, 0.5);
  for (int64_t v = 0; v < disk.vertices.cols(); ++v) {
    disk.vertices(2, v) = -0.3 + disk.vertices.col(v).head<2>().squaredNorm();
    std::swap(disk.vertices(0, v), disk.vertices(1, v));  // faces down, as the bowl does outside
  }
  const ControlMesh start = ControlMesh::Create(disk.vertices, disk.triangles).value();
  const ToleranceFit fit = Fit(start, bowl, 2e-4);
  EXPECT_GT(fit.mesh.vertex_count(), start.vertex_count());
  EXPECT_EQ(fit.mesh.topology().BoundaryLoops().size(), 1u);
}

TEST(ToleranceFitTest, CreasesStay) {
  // The equator of the cage is a crease that the cloud has no need of.
  const ControlMesh smooth = SphereCage(1, 0.45);
  CreaseTags tags;
  for (int32_t e = 0; e < smooth.topology().edge_count(); ++e) {
    const auto& [a, b] = smooth.topology().edge(e);
    if (std::abs(smooth.vertices()(2, a)) < 1e-9 && std::abs(smooth.vertices()(2, b)) < 1e-9) {
      tags.edges.push_back({a, b});
    }
  }
  ASSERT_GT(tags.edges.size(), 3u);
  tags.corners = {tags.edges[0][0]};
  const ControlMesh start =
      ControlMesh::Create(smooth.vertices(), smooth.triangles(), tags).value();
  const ToleranceFit fit = Fit(start, EllipsoidCloud(20'000, {0.5, 0.4, 0.3}), 5e-4, 600);
  EXPECT_GT(fit.mesh.vertex_count(), start.vertex_count());
  EXPECT_GT(fit.mesh.tags().edges.size(), tags.edges.size());
  EXPECT_EQ(fit.mesh.tags().corners, tags.corners);
  // The same curves, of more edges: new vertices lie within one, old ones have what they had.
  const auto degrees = [](const ControlMesh& mesh) {
    std::vector<int> degree(mesh.vertex_count(), 0);
    for (const auto& [a, b] : mesh.tags().edges) ++degree[a], ++degree[b];
    return degree;
  };
  std::vector<int> expected = degrees(start);
  expected.resize(fit.mesh.vertex_count(), 0);
  const std::vector<int> found = degrees(fit.mesh);
  for (int32_t v = 0; v < fit.mesh.vertex_count(); ++v) {
    if (v < start.vertex_count()) {
      EXPECT_EQ(found[v], expected[v]);
    } else {
      EXPECT_TRUE(found[v] == 0 || found[v] == 2) << found[v];
    }
  }
}

TEST(ToleranceFitTest, ItIsTheSameTwice) {
  const PointCloud cloud = BumpyCloud(5000);
  const ToleranceFit a = Fit(SphereCage(1, 0.45), cloud, 2e-3),
                     b = Fit(SphereCage(1, 0.45), cloud, 2e-3);
  EXPECT_EQ(a.fitted, b.fitted);
  EXPECT_EQ(a.mesh.triangles(), b.mesh.triangles());
}

TEST(ToleranceFitTest, IsCancelled) {
  const auto fit = FitToTolerance(SphereCage(1, 0.45), BumpyCloud(5000), ToleranceOptions(),
                                  FitOptions(), [] { return true; });
  EXPECT_TRUE(absl::IsCancelled(fit.status())) << fit.status();
}

TEST(ToleranceFitTest, RefusesOptionsOutOfRange) {
  for (const double tolerance : {0.0, -1e-3, 0.2, std::nan("")}) {
    EXPECT_TRUE(absl::IsInvalidArgument(ToleranceOptions{tolerance, 0}.Validate())) << tolerance;
  }
  EXPECT_THAT(std::string(ToleranceOptions{1e-3, -5}.Validate().message()),
              ::testing::HasSubstr("max_vertices is -5"));
  EXPECT_EQ(ToleranceOptions().Validate(), absl::OkStatus());
}

}  // namespace
}  // namespace cagefit
