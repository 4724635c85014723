#include "core/subdiv/surface_projector.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/core/subdiv/subdiv_samples.h"
#include "tests/core/subdiv/surface_samples.h"
#include "tests/support/data.h"
#include "tests/support/mesh_file.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using testing::RandomSurfacePoints;
using testing::SubdivSample;
using testing::SubdivSamples;
using testing::TopologyOf;

struct Projected {
  explicit Projected(const SubdivSample& sample)
      : surface(sample.topology, sample.tags), projector(&surface, sample.tags) {
    projector.SetVertices(sample.V);
  }
  SurfaceJet At(const SurfacePoint& point, Derivatives derivatives = Derivatives::kFirst) const {
    return surface.Evaluate(projector.control_points(), point, derivatives);
  }
  LimitSurface surface;
  SurfaceProjector projector;
};

SubdivSample SampleOf(const std::string& name, const TriangleMesh& mesh, CreaseTags tags = {}) {
  return {name, mesh.vertices, TopologyOf(mesh), std::move(tags)};
}

std::vector<SubdivSample> Models() {
  std::vector<SubdivSample> models;
  for (const char* name : {"control/bunny_314.obj", "control/spot_829.obj", "static/torus_2304.ply",
                           "static/hemisphere_1861.ply"}) {
    models.push_back(SampleOf(name, testing::ReadTestMesh(name)));
  }
  return models;
}

// In the box grown on all sides by its size times `margin`.
Points3d PointsIn(const Box& box, double margin, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-margin, 1 + margin);
  Points3d X(3, count);
  for (int64_t k = 0; k < count; ++k) {
    const Eigen::Vector3d t(uniform(random), uniform(random), uniform(random));
    X.col(k) = box.min + t.cwiseProduct(box.size());
  }
  return X;
}

// The limit mesh of `levels` refinements; its vertices lie on the surface.
struct FineMesh {
  FineMesh(const SubdivSample& sample, int levels) {
    LimitMesh mesh = BuildLimitMesh(sample.topology, sample.tags, levels);
    ApplyStencils(mesh.position, sample.V, &vertices);
    bvh.Build(vertices, mesh.triangles);
  }
  Points3d vertices;
  TriangleBvh bvh;
};

// No vertex of a much finer mesh is nearer than the foot, beyond what the header allows.
void ExpectNearest(const SubdivSample& sample, int levels, int count) {
  SCOPED_TRACE(sample.name);
  const Projected p(sample);
  const FineMesh fine(sample, levels), coarse(sample, 1);
  double deviation = 0;  // of the surface from the limit mesh of one refinement
  for (int64_t k = 0; k < fine.vertices.cols(); ++k) {
    deviation = std::max(deviation, coarse.bvh.Closest(fine.vertices.col(k)).distance);
  }
  const Box box = BoundingBox(sample.V);
  const Points3d X = PointsIn(box, 0.3, count, 3);
  std::vector<SurfaceFoot> feet;
  p.projector.Closest(X, &feet);
  for (int64_t i = 0; i < X.cols(); ++i) {
    // The nearest vertex is no nearer than the nearest point, which lies beside it.
    const double nearest = (fine.vertices.colwise() - X.col(i)).colwise().norm().minCoeff();
    EXPECT_LE(feet[i].distance, nearest + 2 * deviation + 1e-9 * box.diagonal()) << "point " << i;
  }
}

TEST(SurfaceProjectorTest, NoSampleOfTheSurfaceIsNearerThanTheFoot) {
  for (const SubdivSample& sample : SubdivSamples()) ExpectNearest(sample, 4, 500);
}

TEST(SurfaceProjectorTest, NoSampleOfAModelIsNearerThanTheFoot) {
  CAGEFIT_NEEDS_DATA();
  for (const SubdivSample& sample : Models()) ExpectNearest(sample, 3, 500);
}

// The descent may not stop short: no point around the foot is nearer, in any triangle that holds
// it.
void ExpectLocalMinima(const SubdivSample& sample, int count) {
  SCOPED_TRACE(sample.name);
  const Projected p(sample);
  const double diagonal = BoundingBox(sample.V).diagonal();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> around(-1, 1);
  const Points3d X = PointsIn(BoundingBox(sample.V), 0.3, count, 4);
  for (int64_t i = 0; i < X.cols(); ++i) {
    const Eigen::Vector3d x = X.col(i);
    const SurfaceFoot foot = p.projector.Closest(x);
    EXPECT_LT((p.At(foot.at).position - foot.position).norm(), 1e-12 * diagonal);
    EXPECT_NEAR((foot.position - x).norm(), foot.distance, 1e-12 * diagonal);
    std::vector<SurfacePoint> seen = {foot.at};
    for (int c = 0; c < 3; ++c) {
      const double weights[3] = {1 - foot.at.u - foot.at.v, foot.at.u, foot.at.v};
      if (weights[(c + 2) % 3] > 1e-9) continue;
      const SurfacePoint other = p.surface.Across(foot.at, c);
      if (other.face >= 0) seen.push_back(other);
    }
    for (const SurfacePoint& at : seen) {
      for (const double radius : {1e-2, 1e-3, 1e-4}) {
        for (int k = 0; k < 4; ++k) {
          const SurfacePoint beside = {at.face, at.u + radius * around(random),
                                       at.v + radius * around(random)};
          if (beside.u < 0 || beside.v < 0 || beside.u + beside.v > 1) continue;
          EXPECT_GT((p.At(beside).position - x).norm(), foot.distance - 1e-10 * diagonal)
              << "face " << at.face << " u " << at.u << " v " << at.v;
        }
      }
    }
  }
}

TEST(SurfaceProjectorTest, NoPointBesideAFootIsNearer) {
  for (const SubdivSample& sample : SubdivSamples()) ExpectLocalMinima(sample, 1000);
}

TEST(SurfaceProjectorTest, NoPointOfAModelBesideAFootIsNearer) {
  CAGEFIT_NEEDS_DATA();
  for (const SubdivSample& sample : Models()) ExpectLocalMinima(sample, 2000);
}

// Where the surface is smooth the way to the foot is along its normal.
void ExpectOrthogonal(const SubdivSample& sample, int count) {
  SCOPED_TRACE(sample.name);
  const Projected p(sample);
  const Box box = BoundingBox(sample.V);
  const Points3d X = PointsIn(box, 0.3, count, 6);
  std::vector<SurfaceFoot> feet;
  p.projector.Closest(X, &feet);
  int inner = 0;
  for (int64_t i = 0; i < X.cols(); ++i) {
    const Eigen::Vector3d r = X.col(i) - feet[i].position;
    EXPECT_NEAR(feet[i].normal.norm(), 1, 1e-12);
    if (feet[i].on_boundary) continue;
    ++inner;
    EXPECT_LT(r.cross(feet[i].normal).norm(), 1e-7 * box.diagonal()) << "point " << i;
  }
  EXPECT_GT(inner, count / 10);
}

TEST(SurfaceProjectorTest, FeetOfASmoothSurfaceAreOrthogonal) {
  for (const SubdivSample& sample :
       {SampleOf("Torus", testing::Torus(9, 7)), SampleOf("Icosphere", testing::Icosphere(1)),
        SampleOf("Tube", testing::Tube(8, 5)), SampleOf("Grid", testing::OpenGrid(5))}) {
    ExpectOrthogonal(sample, 5000);
  }
}

TEST(SurfaceProjectorTest, FeetOfAModelAreOrthogonal) {
  CAGEFIT_NEEDS_DATA();
  for (const SubdivSample& sample : Models()) ExpectOrthogonal(sample, 5000);
}

// Control vertices of valence 4, 5 and 6 in the plane z = 0: the surface is flat, whatever the
// parametrisation.
TEST(SurfaceProjectorTest, FeetOnAFlatSurfaceAreStraightBelow) {
  SubdivSample flat = SampleOf("flat", testing::OpenDisk(4));
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(-0.03, 0.03);
  for (int64_t k = 0; k < flat.V.cols(); ++k) {
    flat.V.col(k) += Eigen::Vector3d(uniform(random), uniform(random), 0);
  }
  const Projected p(flat);
  for (const SurfacePoint& at : RandomSurfacePoints(flat.topology, 2000, 9)) {
    const Eigen::Vector3d q = p.At(at).position;
    for (const double height : {0.0, 0.1, -3.0, 1000.0}) {
      const SurfaceFoot foot =
          p.projector.Closest(Eigen::Vector3d(q + Eigen::Vector3d(0, 0, height)));
      EXPECT_LT((foot.position - q).norm(), 1e-9);
      EXPECT_NEAR(foot.distance, std::abs(height), 1e-9);
      EXPECT_LT((foot.normal - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);
    }
  }
}

// Random points, corners, edges and places close to corners.
std::vector<SurfacePoint> ManyPointsOn(const Topology& topology, int count, unsigned seed) {
  std::vector<SurfacePoint> points = RandomSurfacePoints(topology, count, seed);
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    points.insert(points.end(), {{f, 0, 0}, {f, 1, 0}, {f, 0.5, 0.5}, {f, 1e-7, 2e-7}});
  }
  return points;
}

TEST(SurfaceProjectorTest, PointsOfTheSurfaceAreTheirOwnFeet) {
  for (const SubdivSample& sample : SubdivSamples()) {
    SCOPED_TRACE(sample.name);
    const Projected p(sample);
    // Random flips fold the surface: other sheets of the limit mesh are nearer, and beside a vertex
    // another sheet can be a minimum of its own.
    const bool is_folded = sample.V.cols() == testing::MixedValences().vertices.cols();
    const double bound = (is_folded ? 1e-5 : 1e-7) * BoundingBox(sample.V).diagonal();
    for (const SurfacePoint& at : ManyPointsOn(sample.topology, 1000, 10)) {
      const Eigen::Vector3d x = p.At(at).position;
      const SurfacePoint start = {at.face, at.u + 1e-3 * (0.3 - at.u), at.v + 1e-3 * (0.3 - at.v)};
      const double tracked = p.projector.Track(x, start).distance;
      const double closest = is_folded ? 0 : p.projector.Closest(x).distance;
      EXPECT_LT(std::max(tracked, closest), bound)
          << "face " << at.face << " u " << at.u << " v " << at.v;
    }
  }
}

TEST(SurfaceProjectorTest, FeetBeyondABoundaryLieOnItAndSaySo) {
  const SubdivSample disk = SampleOf("disk", testing::OpenDisk(4));
  const Projected p(disk);
  for (int k = 0; k < 100; ++k) {
    const double angle = 0.0628 * k;
    const Eigen::Vector3d x(2 * std::cos(angle), 2 * std::sin(angle), 0.1);
    const SurfaceFoot foot = p.projector.Closest(x);
    EXPECT_TRUE(foot.on_boundary);
    // Across the boundary nothing holds it back; along it the way is orthogonal.
    const Eigen::Vector3d r = x - foot.position;
    EXPECT_GT(r.dot(foot.position), 0);
    EXPECT_GT(foot.position.norm(), 0.9);
    EXPECT_FALSE(p.projector.Closest(Eigen::Vector3d(x / 4)).on_boundary);
  }
}

// A cube whose edges are creases and whose corners are tagged: as flat and as sharp as its control
// mesh.
TEST(SurfaceProjectorTest, FeetOnASharpCubeAreThoseOfTheCube) {
  TriangleMesh cube;
  cube.vertices.resize(3, 8);
  for (int k = 0; k < 8; ++k) cube.vertices.col(k) << k % 2, k / 2 % 2, k / 4;
  cube.triangles.resize(3, 12);
  cube.triangles << 0, 0, 4, 4, 0, 0, 2, 2, 0, 0, 1, 1,  // first corners
      2, 3, 5, 7, 1, 5, 7, 3, 4, 6, 3, 7,                // second
      3, 1, 7, 6, 5, 4, 6 + 0, 7, 6, 2, 7, 5;            // third
  cube.triangles.col(6) << 2, 6, 7;
  cube.triangles.col(7) << 2, 7, 3;
  CreaseTags tags;
  for (int a = 0; a < 8; ++a) {
    tags.corners.push_back(a);
    for (const int bit : {1, 2, 4}) {
      if ((a & bit) == 0) tags.edges.push_back({a, a | bit});
    }
  }
  const SubdivSample sample = SampleOf("cube", cube, tags);
  const Projected p(sample);
  const Points3d X = PointsIn(BoundingBox(sample.V), 1, 5000, 11);
  for (int64_t k = 0; k < X.cols(); ++k) {
    const Eigen::Vector3d x = X.col(k);
    const Eigen::Vector3d clamped = x.cwiseMax(0).cwiseMin(1);
    const double inside = x.cwiseMin(Eigen::Vector3d::Ones() - x).minCoeff();
    const SurfaceFoot foot = p.projector.Closest(x);
    EXPECT_NEAR(foot.distance, inside > 0 ? inside : (x - clamped).norm(), 1e-9);
    if (inside > 0) continue;
    EXPECT_LT((foot.position - clamped).norm(), 1e-8) << x.transpose();
  }
}

TEST(SurfaceProjectorTest, FarPointsHaveFeetOnTheNearSide) {
  const SubdivSample sample = SampleOf("sphere", testing::Icosphere(2));
  const Projected p(sample);
  for (const double distance : {10.0, 1e3, 1e6}) {
    const Points3d X = distance * PointsIn(BoundingBox(sample.V), 0, 200, 12);
    for (int64_t k = 0; k < X.cols(); ++k) {
      const SurfaceFoot foot = p.projector.Closest(Eigen::Vector3d(X.col(k)));
      EXPECT_GT(foot.normal.dot(X.col(k).normalized()), 0.99);
      EXPECT_LT((X.col(k) - foot.position).normalized().cross(foot.normal).norm(), 1e-6);
    }
  }
}

TEST(SurfaceProjectorTest, TrackFollowsAFootAcrossTriangles) {
  const SubdivSample sample = SampleOf("torus", testing::Torus(9, 7));
  const Projected p(sample);
  Eigen::Vector3d x(1.5, 0, 0);
  SurfacePoint at = p.projector.Closest(x).at;
  for (int k = 0; k < 400; ++k) {
    const double angle = 0.02 * k;
    x << 1.5 * std::cos(angle), 1.5 * std::sin(angle), 0.2 * std::sin(3 * angle);
    const SurfaceFoot tracked = p.projector.Track(x, at), closest = p.projector.Closest(x);
    EXPECT_LT((tracked.position - closest.position).norm(), 1e-8) << "step " << k;
    at = tracked.at;
  }
}

TEST(SurfaceProjectorTest, BatchesAreTheSameToTheBitForAnyNumberOfThreads) {
  const SubdivSample sample = SubdivSamples().front();
  const Projected p(sample);
  const Points3d X = PointsIn(BoundingBox(sample.V), 0.1, 3000, 13);
  std::vector<SurfaceFoot> feet, again;
  for (const int threads : {1, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    p.projector.Closest(X, &feet);
    again = feet;
    p.projector.Track(X, &again);
    for (int64_t i = 0; i < X.cols(); ++i) {
      const SurfaceFoot one = p.projector.Closest(Eigen::Vector3d(X.col(i)));
      EXPECT_EQ(feet[i].position, one.position);
      EXPECT_EQ(again[i].position, p.projector.Track(X.col(i), one.at).position);
    }
  }
}

TEST(LimitSurfaceTest, PositionRowsAndTheRefinementGiveTheStencils) {
  for (const SubdivSample& sample : SubdivSamples()) {
    SCOPED_TRACE(sample.name);
    const LimitSurface surface(sample.topology, sample.tags);
    const std::vector<SurfacePoint> points = RandomSurfacePoints(sample.topology, 200, 14);
    const auto stencils = surface.Stencils(points, Derivatives::kNone);
    ASSERT_TRUE(stencils.ok());
    const Eigen::MatrixXd S = stencils->position, R = surface.refinement();
    const int64_t n = surface.vertex_count();
    SurfaceRow row;
    for (size_t i = 0; i < points.size(); ++i) {
      surface.PositionRow(points[i], &row);
      Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(n);
      for (const auto& [point, weight] : row) {
        if (point < n) {
          sum(point) += weight;
        } else {
          sum += weight * R.row(point - n);
        }
      }
      EXPECT_LT((sum - S.row(static_cast<int64_t>(i))).lpNorm<Eigen::Infinity>(), 1e-14);
    }
  }
}

}  // namespace
}  // namespace cagefit
