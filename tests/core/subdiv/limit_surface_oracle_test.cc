// LimitSurface against OpenSubdiv at random points.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/subdiv/corner_fan.h"
#include "core/subdiv/limit_surface.h"
#include "core/subdiv/refine.h"
#include "core/subdiv/sharp_features.h"
#include "tests/core/subdiv/opensubdiv_surface.h"
#include "tests/core/subdiv/subdiv_samples.h"
#include "tests/core/subdiv/surface_samples.h"
#include "tests/support/data.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using testing::Angle;
using testing::Corner;
using testing::Hubs;
using testing::Ours;
using testing::SubdivSample;

constexpr int kPoints = 10'000;
constexpr int kDepth = 10, kOtherDepth = 8;

std::vector<SurfacePoint> SortedPoints(const SubdivSample& sample, int count) {
  std::vector<SurfacePoint> points = testing::RandomSurfacePoints(sample.topology, count, 5);
  std::sort(points.begin(), points.end(),
            [](const SurfacePoint& a, const SurfacePoint& b) { return a.face < b.face; });
  return points;
}

// Largest differences: of positions, over the diagonal; of normals, in radians; of second
// derivatives, over the largest one and but for their sign, which OpenSubdiv 3.5 gets wrong in the
// middle one of four triangles (limit_surface_test.cc has finite differences).
struct Difference {
  double position = 0, normal = 0, second = 0;
};

Difference Compare(const SubdivSample& sample, const std::vector<SurfaceJet>& a,
                   const std::vector<SurfaceJet>& b) {
  Difference worst;
  double largest = 0;
  for (size_t k = 0; k < a.size(); ++k) {
    worst.position = std::max(worst.position, (a[k].position - b[k].position).norm());
    worst.normal = std::max(worst.normal, Angle(a[k], b[k]));
    for (const auto part : {&SurfaceJet::duu, &SurfaceJet::duv, &SurfaceJet::dvv}) {
      worst.second = std::max(worst.second, std::min((a[k].*part - b[k].*part).norm(),
                                                     (a[k].*part + b[k].*part).norm()));
      largest = std::max(largest, (b[k].*part).norm());
    }
  }
  worst.position /= BoundingBox(sample.V).diagonal();
  worst.second /= largest;
  return worst;
}

void ExpectOpenSubdivsSurface(const SubdivSample& sample, int count) {
  SCOPED_TRACE(sample.name);
  const std::vector<SurfacePoint> points = SortedPoints(sample, count);
  const std::vector<SurfaceJet> oracle =
      testing::OpenSubdivSurface(sample.topology, sample.tags, sample.V, points, kDepth);
  const Difference ours = Compare(sample, Ours(sample, points, Derivatives::kSecond), oracle);
  EXPECT_LT(ours.position, 1e-12);
  EXPECT_LT(ours.normal, 1e-8);
  EXPECT_LT(ours.second, 1e-9);
  const Difference depths = Compare(
      sample,
      testing::OpenSubdivSurface(sample.topology, sample.tags, sample.V, points, kOtherDepth),
      oracle);
  EXPECT_LT(depths.position, 1e-9);
  EXPECT_LT(depths.normal, 1e-5);
}

TEST(LimitSurfaceOracleTest, SamplesAreOpenSubdivsSurface) {
  for (const SubdivSample& sample : testing::SubdivSamples()) {
    ExpectOpenSubdivsSurface(sample, kPoints);
  }
}

TEST(LimitSurfaceOracleTest, TouchingVerticesOfHighValenceAreOpenSubdivsSurface) {
  const SubdivSample hubs = Hubs();
  std::vector<char> seen(21, 0);
  for (int32_t v = 0; v < hubs.topology.vertex_count(); ++v) seen[hubs.topology.Valence(v)] = 1;
  EXPECT_EQ(std::count(seen.begin() + 3, seen.end(), 1), 18);
  ExpectOpenSubdivsSurface(hubs, kPoints);
}

TEST(LimitSurfaceOracleTest, ModelsAreOpenSubdivsSurface) {
  CAGEFIT_NEEDS_DATA();
  for (const SubdivSample& model : testing::SurfaceModels())
    ExpectOpenSubdivsSurface(model, kPoints);
}

TEST(LimitSurfaceOracleTest, AnyValenceFrom3To50IsOpenSubdivsSurface) {
  for (int valence = 3; valence <= 50; ++valence) {
    const TriangleMesh mesh = testing::Bipyramid(valence);
    ExpectOpenSubdivsSurface(
        {"valence " + std::to_string(valence), mesh.vertices, testing::TopologyOf(mesh), {}}, 500);
  }
}

// What the depth is for: with little of it the oracle is no oracle.
TEST(LimitSurfaceOracleTest, AShallowOracleDiffers) {
  const SubdivSample hubs = Hubs();
  const std::vector<SurfacePoint> points = SortedPoints(hubs, kPoints);
  const Difference shallow =
      Compare(hubs, Ours(hubs, points, Derivatives::kFirst),
              testing::OpenSubdivSurface(hubs.topology, hubs.tags, hubs.V, points, 2));
  EXPECT_GT(shallow.position, 1e-6);
}

// The corners of the triangles at smooth vertices inside: both have their normals from limit masks.
// OpenSubdiv has none for darts.
TEST(LimitSurfaceOracleTest, NormalsOfSmoothVerticesAreOpenSubdivs) {
  std::vector<SubdivSample> samples = testing::SubdivSamples();
  samples.push_back(Hubs());
  for (const SubdivSample& sample : samples) {
    SCOPED_TRACE(sample.name);
    const SharpFeatures sharp = FindSharpFeatures(sample.topology, sample.tags);
    const std::vector<int32_t> darts = testing::Darts(sample.topology, sample.tags);
    std::vector<SurfacePoint> points;
    for (int32_t f = 0; f < sample.topology.triangle_count(); ++f) {
      for (int c = 0; c < 3; ++c) {
        const int32_t v = sample.topology.triangles()(c, f);
        const bool is_dart = std::find(darts.begin(), darts.end(), v) != darts.end();
        if (sharp.vertex_rule[v] == VertexRule::kSmooth && !is_dart) points.push_back(Corner(f, c));
      }
    }
    const Difference corners =
        Compare(sample, Ours(sample, points, Derivatives::kFirst),
                testing::OpenSubdivSurface(sample.topology, sample.tags, sample.V, points, kDepth));
    EXPECT_LT(corners.position, 1e-6);
    EXPECT_LT(corners.normal, 1e-3);
  }
}

}  // namespace
}  // namespace cagefit
