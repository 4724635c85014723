#include "core/subdiv/surface_sampler.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/subdiv/limit.h"
#include "core/subdiv/limit_surface.h"
#include "tests/core/subdiv/subdiv_samples.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using testing::SubdivSample;
using testing::SubdivSamples;
using testing::TopologyOf;

// Area of each control triangle's part of the surface, and of each triangle of the mesh refined
// once, from a much finer mesh.
std::vector<double> Areas(const SubdivSample& sample, int finer) {
  const LimitMesh mesh = BuildLimitMesh(sample.topology, sample.tags, finer);
  Points3d V;
  ApplyStencils(mesh.position, sample.V, &V);
  const auto per_part = mesh.triangles.cols() / (4 * sample.topology.triangle_count());
  std::vector<double> areas(4 * sample.topology.triangle_count(), 0);
  for (int64_t t = 0; t < mesh.triangles.cols(); ++t) {
    const Eigen::Vector3d a = V.col(mesh.triangles(0, t));
    areas[t / per_part] += 0.5 * (V.col(mesh.triangles(1, t)) - a)
                                     .cross(Eigen::Vector3d(V.col(mesh.triangles(2, t)) - a))
                                     .norm();
  }
  return areas;
}

// Which of the four children of its triangle the point lies in (refine.h).
int ChildOf(const SurfacePoint& p) {
  if (p.u + p.v <= 0.5) return 0;
  return p.u >= 0.5 ? 1 : p.v >= 0.5 ? 2 : 3;
}

TEST(SurfaceSamplerTest, EveryPartGetsItsShareByArea) {
  for (const SubdivSample& sample : SubdivSamples()) {
    SCOPED_TRACE(sample.name);
    const std::vector<double> areas = Areas(sample, 5);
    double total = 0;
    for (const double area : areas) total += area;
    constexpr int kPerTriangle = 40;
    const auto points = AreaPoints(sample.topology, sample.tags, sample.V, kPerTriangle, 3);
    ASSERT_TRUE(points.ok()) << points.status();
    ASSERT_EQ(points->size(), 40u * sample.topology.triangle_count());
    std::vector<double> counts(areas.size(), 0);
    for (const SurfacePoint& p : *points) {
      ASSERT_TRUE(p.u >= 0 && p.v >= 0 && p.u + p.v <= 1);
      ++counts[4 * p.face + ChildOf(p)];
    }
    // Independent draws would give the number of parts; stratified ones less.
    double chi_square = 0;
    for (size_t part = 0; part < areas.size(); ++part) {
      const double expected = areas[part] / total * static_cast<double>(points->size());
      chi_square += (counts[part] - expected) * (counts[part] - expected) / expected;
      EXPECT_NEAR(counts[part], expected, 1 + 0.4 * expected);  // by two refinements, where folded
    }
    EXPECT_LT(chi_square, 0.25 * static_cast<double>(areas.size()));
  }
}

// Within a triangle of a flat regular mesh: as many points in each of 16 parts of the same area.
TEST(SurfaceSamplerTest, PointsAreUniformWithinATriangle) {
  const TriangleMesh torus = testing::Torus(40, 40, 100, 1);
  const auto points = AreaPoints(TopologyOf(torus), {}, torus.vertices, 16, 5);
  ASSERT_TRUE(points.ok());
  double counts[16] = {};
  for (const SurfacePoint& p : *points) {
    const int child = ChildOf(p);
    const double w = 1 - p.u - p.v;
    const SurfacePoint inner = child == 0   ? SurfacePoint{0, 2 * p.u, 2 * p.v}
                               : child == 1 ? SurfacePoint{0, 2 * p.v, 2 * w}
                               : child == 2 ? SurfacePoint{0, 2 * w, 2 * p.u}
                                            : SurfacePoint{0, 1 - 2 * w, 1 - 2 * p.u};
    ++counts[4 * child + ChildOf(inner)];
  }
  double chi_square = 0;
  const double expected = static_cast<double>(points->size()) / 16;
  for (const double count : counts)
    chi_square += (count - expected) * (count - expected) / expected;
  EXPECT_LT(chi_square, 37.7);  // of 15 degrees of freedom, once in a thousand
}

TEST(SurfaceSamplerTest, EveryTriangleGetsItsShareRoundedUpOrDown) {
  // A regular torus: triangles of a row are of the same size to rounding.
  const TriangleMesh torus = testing::Torus(12, 8);
  const Topology topology = TopologyOf(torus);
  const auto points = AreaPoints(topology, {}, torus.vertices, 4, 1);
  ASSERT_TRUE(points.ok());
  std::vector<int> counts(topology.triangle_count(), 0);
  for (const SurfacePoint& p : *points) ++counts[p.face];
  const std::vector<double> parts = Areas({"torus", torus.vertices, topology, {}}, 3);
  double total = 0;
  for (const double part : parts) total += part;
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    const double area = parts[4 * f] + parts[4 * f + 1] + parts[4 * f + 2] + parts[4 * f + 3];
    EXPECT_NEAR(counts[f], area / total * static_cast<double>(points->size()), 1.05);
  }
}

TEST(SurfaceSamplerTest, TheSameSeedGivesTheSamePoints) {
  const SubdivSample sample = SubdivSamples().front();
  const auto draw = [&](uint64_t seed) {
    return *AreaPoints(sample.topology, sample.tags, sample.V, 3, seed);
  };
  const std::vector<SurfacePoint> a = draw(1), b = draw(1), c = draw(2);
  int same = 0;
  for (size_t k = 0; k < a.size(); ++k) {
    EXPECT_TRUE(a[k].face == b[k].face && a[k].u == b[k].u && a[k].v == b[k].v);
    same += a[k].u == c[k].u;
  }
  EXPECT_EQ(same, 0);
}

TEST(SurfaceSamplerTest, FixedSamplingsAreTheVerticesOfTheLimitMeshes) {
  for (const SubdivSample& sample : SubdivSamples()) {
    SCOPED_TRACE(sample.name);
    const LimitSurface surface(sample.topology, sample.tags);
    for (const int level : {0, 1}) {
      const auto rows = surface.Stencils(
          level == 0 ? ControlVertexPoints(sample.topology) : RefinedVertexPoints(sample.topology),
          Derivatives::kNone);
      ASSERT_TRUE(rows.ok()) << rows.status();
      const LimitMesh mesh = BuildLimitMesh(sample.topology, sample.tags, level);
      const Eigen::MatrixXd difference =
          Eigen::MatrixXd(rows->position) - Eigen::MatrixXd(mesh.position);
      EXPECT_LT(difference.lpNorm<Eigen::Infinity>(), 1e-13);
    }
  }
}

TEST(SurfaceSamplerTest, StencilsOfASamplingAreThoseOfItsPoints) {
  const TriangleMesh mesh = testing::MixedValences();
  const ControlMesh cage = *ControlMesh::Create(mesh.vertices, mesh.triangles);
  EXPECT_EQ(SampleStencils(cage, Sampling::kControlVertices, 0, 0)->rows(), 162);
  EXPECT_EQ(SampleStencils(cage, Sampling::kRefinedVertices, 0, 0)->rows(), 642);
  const auto rows = SampleStencils(cage, Sampling::kArea, 2, 9);
  ASSERT_TRUE(rows.ok()) << rows.status();
  const auto points = AreaPoints(cage.topology(), {}, cage.vertices(), 2, 9);
  Points3d samples, control_points;
  ApplyStencils(*rows, cage.vertices(), &samples);
  const LimitSurface surface(cage.topology(), {});
  surface.ControlPoints(cage.vertices(), &control_points);
  ASSERT_EQ(samples.cols(), 640);
  for (int64_t k = 0; k < samples.cols(); ++k) {
    const SurfaceJet jet = surface.Evaluate(control_points, (*points)[k], Derivatives::kNone);
    EXPECT_LT((samples.col(k) - jet.position).norm(), 1e-13);
  }
}

TEST(SurfaceSamplerTest, NoSamplesAndNoAreaAreErrors) {
  const TriangleMesh mesh = testing::OpenGrid(3);
  EXPECT_EQ(AreaPoints(TopologyOf(mesh), {}, mesh.vertices, 0, 1).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(AreaPoints(TopologyOf(mesh), {}, 0 * mesh.vertices, 1, 1).status().code(),
            absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace cagefit
