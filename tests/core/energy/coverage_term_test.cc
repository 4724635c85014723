#include "core/energy/coverage_term.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/mesh/triangle_bvh.h"
#include "core/subdiv/limit.h"
#include "tests/core/subdiv/subdiv_samples.h"
#include "tests/core/subdiv/surface_samples.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using testing::SubdivSample;
using testing::SubdivSamples;

constexpr double kWeight = 3;
// Half of the points around a sample are farther from it than this.
constexpr double kOffset = 0.05;

SubdivSample SampleOf(const TriangleMesh& mesh) {
  return {"", mesh.vertices, testing::TopologyOf(mesh), {}};
}

// Points at random distances around kOffset from the sample's surface, to all sides, with the
// normals of the places that they come from.
PointCloud CloudAround(const SubdivSample& sample, int count, uint64_t seed) {
  const std::vector<SurfaceJet> jets = testing::Ours(
      sample, testing::RandomSurfacePoints(sample.topology, count, static_cast<unsigned>(seed)),
      Derivatives::kFirst);
  Random random(seed);
  PointCloud cloud;
  cloud.points.resize(3, count);
  cloud.normals.resize(3, count);
  for (int k = 0; k < count; ++k) {
    const double distance = random.Uniform(0, 2 * kOffset);
    const Eigen::Vector3d direction = random.NormalVector().normalized();
    cloud.points.col(k) = (jets[k].position + distance * direction).cast<float>();
    cloud.normals.col(k) = jets[k].du.cross(jets[k].dv).normalized().cast<float>();
  }
  return cloud;
}

// Points at `z` over the inside of the unit square, normals +z.
PointCloud CloudOverSquare(int count, double z) {
  Random random(1);
  PointCloud cloud;
  cloud.points.resize(3, count);
  for (int k = 0; k < count; ++k) {
    cloud.points.col(k) =
        Eigen::Vector3d(random.Uniform(0.2, 0.8), random.Uniform(0.2, 0.8), z).cast<float>();
  }
  cloud.normals = Eigen::Vector3f::UnitZ().replicate(1, count);
  return cloud;
}

Points3d Disturbed(const Points3d& V, double amount, uint64_t seed) {
  Random random(seed);
  return V +
         Points3d::NullaryExpr(3, V.cols(), [&] { return random.Uniform(-amount, amount); }).eval();
}

Points3d HalfGradient(const CoverageTerm& term, int64_t vertices) {
  Points3d half_gradient = Points3d::Zero(3, vertices);
  term.AddHalfGradient(&half_gradient);
  return half_gradient;
}

int64_t CountUsed(const CoverageTerm& term) {
  int64_t used = 0;
  for (int64_t k = 0; k < term.size(); ++k) used += term.is_used(k) ? 1 : 0;
  return used;
}

struct Covered {
  Covered(const SubdivSample& sample, PointCloud target, const RobustKernel& kernel = {})
      : cloud(std::move(target)), term(sample.topology, sample.tags) {
    term.SetTarget(&cloud, cloud.size(), kWeight, kernel);
  }
  PointCloud cloud;
  CoverageTerm term;
};

TEST(CoverageTermTest, IsTheMeanSquaredDistanceOfThePoints) {
  for (const SubdivSample& sample : SubdivSamples()) {
    SCOPED_TRACE(sample.name);
    Covered covered(sample, CloudAround(sample, 400, 1));
    const double energy = covered.term.Assign(sample.V);

    const LimitMesh mesh = BuildLimitMesh(sample.topology, sample.tags, 5);
    Points3d fine;
    ApplyStencils(mesh.position, sample.V, &fine);
    const TriangleBvh bvh(fine, mesh.triangles);
    double sum = 0;
    for (int64_t k = 0; k < 400; ++k) {
      if (!covered.term.is_used(k)) continue;
      const double d = bvh.Closest(covered.cloud.points.col(k).cast<double>()).distance;
      sum += d * d;
    }
    EXPECT_GT(CountUsed(covered.term), 300);
    const double n = static_cast<double>(sample.V.cols());
    const double expected = kWeight * n / 400 * sum;
    EXPECT_GE(energy, 0.999 * expected);
    // Of folds that are about equally near the projector may take either.
    EXPECT_LE(energy, 1.05 * expected);
  }
}

TEST(CoverageTermTest, EvaluatesWhatItAssigned) {
  for (const SubdivSample& sample : SubdivSamples()) {
    Covered covered(sample, CloudAround(sample, 400, 2), {Kernel::kHuber, kOffset});
    const double assigned = covered.term.Assign(sample.V);
    EXPECT_NEAR(covered.term.Evaluate(sample.V), assigned, 1e-12 * assigned) << sample.name;
  }
}

TEST(CoverageTermTest, GradientAgreesWithFiniteDifferencesAtHeldFeet) {
  for (const SubdivSample& sample : SubdivSamples()) {
    for (const Kernel kernel :
         {Kernel::kIdentity, Kernel::kHuber, Kernel::kGemanMcClure, Kernel::kTukey}) {
      SCOPED_TRACE(sample.name + ", kernel " + std::to_string(static_cast<int>(kernel)));
      Covered covered(sample, CloudAround(sample, 600, 3), {kernel, kOffset});
      covered.term.Assign(sample.V);
      for (const double moved : {0.0, 0.02}) {  // from where the feet were chosen
        const Points3d V = Disturbed(sample.V, moved, 4);
        covered.term.Evaluate(V);
        const Points3d half_gradient = HalfGradient(covered.term, V.cols());
        const double scale = 2 * half_gradient.colwise().norm().maxCoeff();
        ASSERT_GT(scale, 0);
        const int64_t stride = std::max<int64_t>(1, V.cols() / 12);
        for (int64_t j = 0; j < V.cols(); j += stride) {
          for (int axis = 0; axis < 3; ++axis) {
            const double step = 1e-6;
            Points3d ahead = V, behind = V;
            ahead(axis, j) += step;
            behind(axis, j) -= step;
            const double difference =
                (covered.term.Evaluate(ahead) - covered.term.Evaluate(behind)) / (2 * step);
            EXPECT_NEAR(2 * half_gradient(axis, j), difference, 1e-6 * scale) << "vertex " << j;
          }
        }
      }
    }
  }
}

// The feet are nearest points: to first order the energy does not care that they are held.
TEST(CoverageTermTest, GradientIsThatOfTheDistanceWhoseFeetFollow) {
  for (const SubdivSample& sample : SubdivSamples()) {
    // On a crease a point may face either side: its part in the energy comes and goes.
    if (!sample.tags.edges.empty()) continue;
    SCOPED_TRACE(sample.name);
    Covered covered(sample, CloudAround(sample, 600, 5));
    covered.term.Assign(sample.V);
    const Points3d half_gradient = HalfGradient(covered.term, sample.V.cols());
    for (uint64_t seed = 6; seed < 9; ++seed) {
      const Points3d direction = Disturbed(Points3d::Zero(3, sample.V.cols()), 1, seed);
      const double step = 1e-4;
      const double ahead = covered.term.Assign(sample.V + step * direction);
      const double behind = covered.term.Assign(sample.V - step * direction);
      EXPECT_NEAR(2 * half_gradient.cwiseProduct(direction).sum(), (ahead - behind) / (2 * step),
                  1e-2 * half_gradient.norm());
    }
  }
}

TEST(CoverageTermTest, AddsItsGradientToWhatIsThere) {
  const SubdivSample sample = SampleOf(testing::Icosphere(1));
  Covered covered(sample, CloudAround(sample, 300, 7));
  covered.term.Assign(sample.V);
  Points3d sum = Points3d::Constant(3, sample.V.cols(), 5);
  covered.term.AddHalfGradient(&sum);
  EXPECT_NEAR(
      (sum.array() - 5 - HalfGradient(covered.term, sample.V.cols()).array()).abs().maxCoeff(), 0,
      1e-13);
}

TEST(CoverageTermTest, PointsThatFaceAwayTakeNoPart) {
  const SubdivSample sample = SampleOf(testing::OpenGrid(6));
  PointCloud cloud = CloudOverSquare(400, 0.1);
  cloud.normals.leftCols(100) *= -1;
  Covered covered(sample, cloud);
  const double n = static_cast<double>(sample.V.cols());
  EXPECT_NEAR(covered.term.Assign(sample.V), kWeight * n * 300 / 400 * 0.01, 1e-6);
  EXPECT_FALSE(covered.term.is_used(99));
  EXPECT_TRUE(covered.term.is_used(100));

  covered.cloud.normals.rightCols(300) *= -1;
  covered.term.SetTarget(&covered.cloud, 400, kWeight, {});
  EXPECT_EQ(covered.term.Assign(sample.V), 0);
  EXPECT_EQ(HalfGradient(covered.term, sample.V.cols()), Points3d::Zero(3, sample.V.cols()));
}

TEST(CoverageTermTest, IsOffWithoutWeightOrTarget) {
  const SubdivSample sample = SampleOf(testing::Icosphere(1));
  const PointCloud cloud = CloudAround(sample, 300, 8);
  CoverageTerm term(sample.topology, sample.tags);
  for (const PointCloud* target : {&cloud, static_cast<const PointCloud*>(nullptr)}) {
    term.SetTarget(&cloud, 300, kWeight, {});
    term.Assign(sample.V);
    term.SetTarget(target, 300, target != nullptr ? 0 : kWeight, {});
    EXPECT_FALSE(term.is_on());
    EXPECT_EQ(term.Assign(sample.V), 0);
    EXPECT_EQ(term.Evaluate(sample.V), 0);
    EXPECT_EQ(term.size(), 0);
    EXPECT_EQ(HalfGradient(term, sample.V.cols()), Points3d::Zero(3, sample.V.cols()));
    SurfaceBlocks blocks;
    blocks.SetZero(term.m1()->topology);
    term.AddBlocks(&blocks);
    for (const Eigen::Matrix3f& block : blocks.vertex) EXPECT_EQ(block, Eigen::Matrix3f::Zero());
  }
}

TEST(CoverageTermTest, TakesPointsEvenlySpreadOverTheirOrder) {
  const SubdivSample sample = SampleOf(testing::Icosphere(1));
  const PointCloud cloud = CloudAround(sample, 1000, 9);
  CoverageTerm term(sample.topology, sample.tags);
  term.SetTarget(&cloud, 64, kWeight, {});
  term.Assign(sample.V);
  ASSERT_EQ(term.size(), 64);
  for (int64_t k = 0; k < 64; ++k) {
    EXPECT_EQ(term.row(k).target, cloud.points.col(k * 1000 / 64).cast<double>());
  }
}

TEST(CoverageTermTest, ACoarseProblemTakesFewerPointsAndWeighsThemMore) {
  const SubdivSample sample = SampleOf(testing::OpenGrid(6));
  const double n = static_cast<double>(sample.V.cols());
  Covered covered(sample, CloudOverSquare(401, 0.1));
  covered.term.SetCoarseness(1, true);
  EXPECT_NEAR(covered.term.Assign(sample.V), kWeight * n * 0.01, 1e-6);
  EXPECT_EQ(CountUsed(covered.term), 101);
  for (int64_t k = 0; k < 401; ++k) {
    EXPECT_EQ(covered.term.is_used(k), k % CoverageTerm::kCoarseStride == 0);
  }
  EXPECT_DOUBLE_EQ(covered.term.row(0).scale, kWeight * n / 101);

  covered.term.SetCoarseness(1, false);
  EXPECT_EQ(CountUsed(covered.term), 101) << "before the next Assign";
  EXPECT_NEAR(covered.term.Evaluate(sample.V), kWeight * n * 0.01, 1e-6);
  EXPECT_NEAR(covered.term.Assign(sample.V), kWeight * n * 0.01, 1e-6);
  EXPECT_EQ(CountUsed(covered.term), 401);
}

TEST(CoverageTermTest, PointsThatTakePartForTheFirstTimeAreSoughtEverywhere) {
  const SubdivSample sample = SampleOf(testing::Torus(20, 12));
  const PointCloud cloud = CloudAround(sample, 500, 10);
  Covered used(sample, cloud), fresh(sample, cloud);
  used.term.SetCoarseness(1, true);
  used.term.Assign(Eigen::Vector3d(-1, -1, 1).asDiagonal() * sample.V);  // half a turn
  used.term.SetCoarseness(1, false);
  used.term.Assign(sample.V);
  fresh.term.Assign(sample.V);
  for (int64_t k = 0; k < used.term.size(); ++k) {
    if (k % CoverageTerm::kCoarseStride == 0) continue;
    EXPECT_TRUE(used.term.is_used(k));
    EXPECT_LT((used.term.row(k).direction - fresh.term.row(k).direction).norm(), 1e-3);
  }
}

TEST(CoverageTermTest, CoarsenessWidensTheKernel) {
  const SubdivSample sample = SampleOf(testing::OpenGrid(6));
  Covered covered(sample, CloudOverSquare(400, 0.1), {Kernel::kTukey, 0.01});
  const double n = static_cast<double>(sample.V.cols());
  EXPECT_NEAR(covered.term.Assign(sample.V), kWeight * n * 0.01 * 0.01 / 3, 1e-9);
  covered.term.SetCoarseness(100, false);
  EXPECT_DOUBLE_EQ(covered.term.kernel().scale, 1);
  const double s = 0.1 * 0.1;
  EXPECT_NEAR(covered.term.Assign(sample.V), kWeight * n / 3 * (1 - std::pow(1 - s, 3)), 1e-6);
}

TEST(CoverageTermTest, SlidingAlongThePlaneCostsNothing) {
  const SubdivSample sample = SampleOf(testing::OpenGrid(6));
  Covered covered(sample, CloudOverSquare(400, 0.1));
  const double energy = covered.term.Assign(sample.V);
  const Points3d half_gradient = HalfGradient(covered.term, sample.V.cols());
  EXPECT_NEAR(half_gradient.topRows(2).cwiseAbs().maxCoeff(), 0, 1e-6);
  EXPECT_NEAR(covered.term.Evaluate(sample.V.colwise() + Eigen::Vector3d(0.1, -0.2, 0)), energy,
              1e-6 * energy);
}

// Turning a torus about its axis moves the surface in itself.
TEST(CoverageTermTest, SlidingAlongACurvedSurfaceCostsNothingToFirstOrder) {
  const SubdivSample sample = SampleOf(testing::Torus(40, 16));
  PointCloud cloud = CloudFromMesh(testing::Torus(97, 31, 1, 0.3));
  Covered covered(sample, cloud);
  covered.term.Assign(sample.V);
  const Points3d half_gradient = HalfGradient(covered.term, sample.V.cols());
  double along = 0, across = 0;
  for (int64_t j = 0; j < sample.V.cols(); ++j) {
    along += half_gradient.col(j).dot(Eigen::Vector3d::UnitZ().cross(sample.V.col(j)));
    across += half_gradient.col(j).norm() * sample.V.col(j).norm();
  }
  EXPECT_LT(std::abs(along), 1e-3 * across);
}

TEST(CoverageTermTest, ABoundaryIsDrawnOutToThePointsBeyondIt) {
  const SubdivSample sample = SampleOf(testing::OpenDisk(5));
  PointCloud cloud;
  cloud.points.resize(3, 200);
  for (int k = 0; k < 200; ++k) {
    const double a = 2 * 3.14159265358979323846 * k / 200;
    cloud.points.col(k) = Eigen::Vector3d(1.15 * std::cos(a), 1.15 * std::sin(a), 0).cast<float>();
  }
  cloud.normals = Eigen::Vector3f::UnitZ().replicate(1, 200);
  Covered covered(sample, cloud);
  const double energy = covered.term.Assign(sample.V);
  EXPECT_EQ(CountUsed(covered.term), 200);
  const double n = static_cast<double>(sample.V.cols());
  EXPECT_NEAR(std::sqrt(energy / (kWeight * n)), 0.15, 0.02);  // the disk's boundary is a polygon's

  const Points3d pull = -HalfGradient(covered.term, sample.V.cols());
  for (int32_t j = 0; j < sample.topology.vertex_count(); ++j) {
    if (!sample.topology.IsBoundaryVertex(j)) continue;
    EXPECT_GT(pull.col(j).dot(sample.V.col(j)), 0.9 * pull.col(j).norm() * sample.V.col(j).norm());
  }
  EXPECT_LT(covered.term.Assign(sample.V + 0.01 / pull.colwise().norm().maxCoeff() * pull), energy);
}

TEST(CoverageTermTest, PointsOutOfReachTakeNoPart) {
  // Edges of 0.2. Two points beside the boundary, two over the middle, one of each too far.
  const SubdivSample sample = SampleOf(testing::OpenDisk(5));
  PointCloud cloud;
  cloud.points.resize(3, 4);
  cloud.points << 1.15f, 1.35f, 0, 0, 0, 0, 0, 0, 0, 0, 0.3f, 0.5f;
  cloud.normals = Eigen::Vector3f::UnitZ().replicate(1, 4);
  Covered covered(sample, cloud);
  covered.term.Assign(sample.V);
  EXPECT_TRUE(covered.term.is_used(0));
  EXPECT_FALSE(covered.term.is_used(1));
  EXPECT_TRUE(covered.term.is_used(2));
  EXPECT_FALSE(covered.term.is_used(3));
}

TEST(CoverageTermTest, PointsOnTheSurfaceHoldItAlongItsNormal) {
  const SubdivSample sample = SampleOf(testing::OpenGrid(6));
  Covered covered(sample, CloudOverSquare(400, 0));
  EXPECT_NEAR(covered.term.Assign(sample.V), 0, 1e-20);
  EXPECT_EQ(CountUsed(covered.term), 400);
  const double n = static_cast<double>(sample.V.cols());
  EXPECT_NEAR(covered.term.Evaluate(sample.V.colwise() + Eigen::Vector3d(0.2, 0, 0.1)),
              kWeight * n * 0.01, 1e-9);
}

TEST(CoverageTermTest, IsTheSameForAnyNumberOfThreads) {
  const SubdivSample sample = SampleOf(testing::MixedValences());
  Covered all(sample, CloudAround(sample, 3000, 11)), one(sample, CloudAround(sample, 3000, 11));
  const double energy = all.term.Assign(sample.V);
  const Points3d half_gradient = HalfGradient(all.term, sample.V.cols());
  tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(one.term.Assign(sample.V), energy);
  EXPECT_EQ(HalfGradient(one.term, sample.V.cols()), half_gradient);
}

// dV^T H dV by the blocks of the Gauss-Newton matrix.
double BlockForm(const CoverageTerm& term, const Points3d& dV) {
  SurfaceBlocks blocks;
  blocks.SetZero(term.m1()->topology);
  term.AddBlocks(&blocks);
  Points3d dQ;
  ApplyStencils(term.m1()->position, dV, &dQ);
  double sum = 0;
  for (int32_t v = 0; v < term.m1()->topology.vertex_count(); ++v) {
    sum += dQ.col(v).dot(blocks.vertex[v].cast<double>() * dQ.col(v));
  }
  for (int32_t e = 0; e < term.m1()->topology.edge_count(); ++e) {
    const auto& [a, b] = term.m1()->topology.edge(e);
    sum += 2 * dQ.col(a).dot(blocks.edge[e].cast<double>() * dQ.col(b));
  }
  return sum;
}

// The same by the exact rows.
double RowForm(const CoverageTerm& term, const Points3d& V, const Points3d& dV) {
  Points3d X, dX;
  term.surface().ControlPoints(V, &X);
  term.surface().ControlPoints(dV, &dX);
  double sum = 0;
  for (int64_t k = 0; k < term.size(); ++k) {
    if (!term.is_used(k)) continue;
    const CoverageTerm::Row row = term.row(k);
    Eigen::Vector3d position = Eigen::Vector3d::Zero(), moved = position;
    for (const auto& [point, weight] : row.entries) {
      position += weight * X.col(point);
      moved += weight * dX.col(point);
    }
    const double residual = row.direction.dot(row.target - position);
    double slope = 1;
    term.kernel().Rho(residual * residual, &slope);
    sum += row.scale * slope * std::pow(row.direction.dot(moved), 2);
  }
  return sum;
}

// Slow waves over the mesh's place.
Points3d Wave(const Points3d& V) {
  Points3d wave(3, V.cols());
  for (int64_t j = 0; j < V.cols(); ++j) {
    const Eigen::Vector3d x = V.col(j);
    wave.col(j) << std::sin(3 * x.y() + 1), std::cos(2 * x.z() - x.x()), std::sin(2 * x.x());
  }
  return wave;
}

TEST(CoverageTermTest, BlocksAreExactWhereTheSurfaceMovesAsAWhole) {
  for (const SubdivSample& sample : SubdivSamples()) {
    Covered covered(sample, CloudAround(sample, 600, 12), {Kernel::kGemanMcClure, kOffset});
    covered.term.Assign(sample.V);
    const Points3d dV = Eigen::Vector3d(0.3, -0.5, 0.8).replicate(1, sample.V.cols());
    const double exact = RowForm(covered.term, sample.V, dV);
    EXPECT_NEAR(BlockForm(covered.term, dV), exact, 1e-5 * exact) << sample.name;
  }
}

TEST(CoverageTermTest, BlocksApproachTheExactRowsAsTheMeshGetsFiner) {
  std::vector<double> error;
  for (const int levels : {1, 2, 3}) {
    const SubdivSample sample = SampleOf(testing::Icosphere(levels));
    Covered covered(sample, CloudAround(sample, 4000, 13));
    covered.term.Assign(sample.V);
    const Points3d dV = Wave(sample.V);
    error.push_back(
        std::abs(BlockForm(covered.term, dV) / RowForm(covered.term, sample.V, dV) - 1));
  }
  EXPECT_LT(error[0], 0.1);
  EXPECT_LT(error[1], 0.4 * error[0]);
  EXPECT_LT(error[2], 0.4 * error[1]);
}

TEST(CoverageTermTest, BlocksAreCloseForSlowWaves) {
  for (const SubdivSample& sample : SubdivSamples()) {
    if (sample.V.cols() < 30) continue;
    Covered covered(sample, CloudAround(sample, 1000, 14));
    covered.term.Assign(sample.V);
    const Points3d dV = Wave(sample.V);
    const double exact = RowForm(covered.term, sample.V, dV);
    EXPECT_NEAR(BlockForm(covered.term, dV), exact, 0.06 * exact) << sample.name;
  }
}

TEST(CoverageTermTest, LumpedBlocksAreTheSumsOfTheirRows) {
  const SubdivSample sample = SampleOf(testing::MixedValences());
  Covered covered(sample, CloudAround(sample, 2000, 15));
  covered.term.Assign(sample.V);
  SurfaceBlocks blocks;
  blocks.SetZero(covered.term.m1()->topology);
  covered.term.AddBlocks(&blocks);
  std::vector<Eigen::Matrix3f> rows = blocks.vertex;
  for (int32_t e = 0; e < covered.term.m1()->topology.edge_count(); ++e) {
    for (const int32_t v : covered.term.m1()->topology.edge(e)) rows[v] += blocks.edge[e];
  }
  float largest = 0;
  for (const Eigen::Matrix3f& block : blocks.lumped) largest = std::max(largest, block.norm());
  ASSERT_GT(largest, 0);
  for (size_t v = 0; v < rows.size(); ++v) {
    EXPECT_LT((rows[v] - blocks.lumped[v]).norm(), 1e-5f * largest);
  }
}

}  // namespace
}  // namespace cagefit
