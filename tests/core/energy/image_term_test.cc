#include "core/energy/image_term.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <set>
#include <utility>

#include "core/base/random.h"
#include "core/image/views.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using testing::Icosphere;
using testing::Torus;

// A control mesh, and images of another shape.
struct Problem {
  explicit Problem(const ImageWeights& weights, SilhouetteOptions options = {},
                   int per_iteration = 0)
      : topology(*Topology::Create(cage.vertices.cols(), cage.triangles)),
        m1(std::make_shared<RefinedSurface>(topology, CreaseTags())),
        term(m1, options, per_iteration, /*seed=*/3) {
    TriangleMesh shape = Icosphere(4, 0.5);
    shape.vertices.row(0) *= 1.1;
    shape.vertices.row(1) *= 0.95;
    const MeshEdges edges(shape.triangles);
    for (const Camera& camera : SphereViews(6, {0, 0, 0}, 0.7, 128)) {
      MeshView view;
      view.Render(shape.vertices, shape.triangles, edges, camera, options, Surfaces::kVisible);
      ImageTarget target;
      target.camera = camera;
      target.silhouette = view.silhouette();
      target.depth = DepthImage(view.depths());
      target.normals = NormalImage(view.depths(), shape.vertices, shape.triangles, camera);
      targets.push_back(std::move(target));
    }
    term.SetTarget(&targets, weights, /*frame=*/0);
  }

  TriangleMesh cage = Icosphere(2, 0.5);
  Topology topology;
  std::shared_ptr<const RefinedSurface> m1;
  ImageTerm term;
  std::vector<ImageTarget> targets;
};

// A smooth motion: pixels that come to another triangle or edge on the way are few beside those
// that stay.
Points3d Motion(const Points3d& V, uint64_t seed) {
  Random random(seed);
  const Eigen::Matrix3d M = 2 * Eigen::Matrix3d::NullaryExpr([&] { return random.Normal(); });
  Points3d out = (M * V).array().sin();
  out.row(1) *= 0.5;
  return out;
}

// One image of the moving surface at three moments, and what a pixel of it is.
class MovingImage {
 public:
  MovingImage(const Problem& problem, const Camera& camera, const Points3d& motion, double step,
              const ImageWeights& weights) {
    const Triangles& triangles = problem.m1->topology.triangles();
    const MeshEdges edges(triangles);
    for (int side = 0; side < 3; ++side) {
      Points3d Q;
      ApplyStencils(problem.m1->position, problem.cage.vertices + (side - 1) * step * motion, &Q);
      views_[side].Render(Q, triangles, edges, camera, {}, Surfaces::kVisible);
      const DepthBuffer& depths = views_[side].depths();
      if (side == 1) normals_ = NormalImage(depths, Q, triangles, camera);
      if (weights.silhouette > 0) images_[side] = views_[side].silhouette();
      if (weights.depth > 0) images_[side] = DepthImage(depths);
      if (weights.normals > 0) images_[side] = NormalImage(depths, Q, triangles, camera);
    }
    has_silhouettes_ = weights.silhouette > 0;
    camera_ = camera;
  }

  size_t size() const { return images_[0].values.size(); }
  double value(int side, size_t k) const { return images_[side].values[k]; }

  // Whether value k is differentiable: pixels that come to see another triangle on the way, or see
  // one at too steep an angle, are no matter of derivatives.
  bool IsHeld(size_t k) const {
    if (has_silhouettes_) return true;
    const auto p = static_cast<int>(k) / images_[0].channels;
    const int x = p % camera_.width, y = p / camera_.width;
    const int32_t f = views_[0].depths().triangle(x, y);
    if (f < 0 || f != views_[1].depths().triangle(x, y)) return false;
    if (f != views_[2].depths().triangle(x, y)) return false;
    const float* n = normals_.at(x, y);
    const Eigen::Vector3d ray =
        camera_.R.transpose() *
        Eigen::Vector3d((x - camera_.cx) / camera_.fx, (y - camera_.cy) / camera_.fy, 1);
    return Eigen::Vector3d(n[0], n[1], n[2]).dot(-ray.normalized()) > 0.1;
  }

  // Whether the target has the same sheet there.
  bool IsNear(size_t k, const Image& depth) const {
    if (has_silhouettes_) return true;
    const auto p = static_cast<int>(k) / images_[0].channels;
    const double here = views_[1].depths().depth(p % camera_.width, p / camera_.width);
    return depth.values[p] > 0 && std::abs(here - depth.values[p]) <= ImageTerm::kDepthReach;
  }

 private:
  Camera camera_;
  MeshView views_[3];
  Image images_[3], normals_;
  bool has_silhouettes_ = false;
};

const Image& Wanted(const ImageTarget& target, const ImageWeights& weights) {
  return weights.silhouette > 0 ? target.silhouette
         : weights.depth > 0    ? target.depth
                                : target.normals;
}

// Half the energy's slope along a motion, and the squared slopes of its residuals, by finite
// differences of the images themselves.
std::pair<double, double> Differentiate(const Problem& problem, const Points3d& motion, double step,
                                        const ImageWeights& weights) {
  double slope = 0, squared = 0;
  for (const ImageTarget& target : problem.targets) {
    const MovingImage moving(problem, target.camera, motion, step, weights);
    const Image& wanted = Wanted(target, weights);
    const double weight = 2 / (6.0 * target.silhouette.pixel_count());
    for (size_t k = 0; k < moving.size(); ++k) {
      if (!moving.IsHeld(k) || !moving.IsNear(k, target.depth)) continue;
      const double change = (moving.value(2, k) - moving.value(0, k)) / (2 * step);
      const double r = moving.value(1, k) - wanted.values[k];
      slope += weight * r * change;
      squared += weight * change * change;
    }
  }
  return {slope, squared};
}

void ExpectDerivatives(const ImageWeights& weights, double tolerance, double block_tolerance) {
  Problem problem(weights);
  for (const uint64_t seed : {1, 2, 3}) {
    const Points3d motion = Motion(problem.cage.vertices, seed);
    problem.term.Evaluate(problem.cage.vertices);
    Points3d half = Points3d::Zero(3, motion.cols());
    problem.term.AddHalfGradient(&half);
    SurfaceBlocks blocks;
    blocks.SetZero(problem.m1->topology);
    problem.term.AddBlocks(&blocks);
    Points3d dQ;
    ApplyStencils(problem.m1->position, motion, &dQ);
    double by_blocks = 0;
    for (int32_t v = 0; v < problem.m1->topology.vertex_count(); ++v) {
      by_blocks += dQ.col(v).dot(blocks.vertex[v].cast<double>() * dQ.col(v));
    }
    for (int32_t e = 0; e < problem.m1->topology.edge_count(); ++e) {
      const auto& [a, b] = problem.m1->topology.edge(e);
      by_blocks += 2 * dQ.col(a).dot(blocks.edge[e].cast<double>() * dQ.col(b));
    }
    const auto [slope, squared] = Differentiate(problem, motion, 1e-4, weights);
    EXPECT_NEAR(half.cwiseProduct(motion).sum(), slope, tolerance * std::abs(slope));
    EXPECT_NEAR(by_blocks, squared, block_tolerance * squared);
    EXPECT_GT(squared, 0);
  }
}

TEST(ImageTermTest, DerivativesOfSilhouettesAreThoseOfTheImages) {
  ExpectDerivatives({1, 0, 0}, 5e-3, 0.03);
}

TEST(ImageTermTest, DerivativesOfDepthsAreThoseOfTheImages) {
  ExpectDerivatives({0, 1, 0}, 0.02, 0.02);
}

TEST(ImageTermTest, DerivativesOfNormalsAreThoseOfTheImages) {
  ExpectDerivatives({0, 0, 1}, 0.05, 0.02);
}

TEST(ImageTermTest, GradientInPytorch3dModePassesFiniteDifferences) {
  Problem problem({1, 0, 0}, {SilhouetteMode::kPytorch3d, {}});
  const Points3d& V = problem.cage.vertices;
  for (const uint64_t seed : {1, 2, 3}) {
    const Points3d motion = Motion(V, seed);
    constexpr double kStep = 1e-4;
    const double expected =
        (problem.term.Evaluate(V + kStep * motion) - problem.term.Evaluate(V - kStep * motion)) /
        (4 * kStep);
    problem.term.Evaluate(V);
    Points3d half = Points3d::Zero(3, V.cols());
    problem.term.AddHalfGradient(&half);
    EXPECT_NEAR(half.cwiseProduct(motion).sum(), expected, 5e-3 * std::abs(expected));
  }
}

TEST(ImageTermTest, PixelsThatAreNotObservedCountForNothing) {
  Problem problem({1, 0, 0});
  for (ImageTarget& target : problem.targets) target.observed = Image(128, 128);
  problem.term.SetTarget(&problem.targets, {1, 0, 0}, 0);
  EXPECT_EQ(problem.term.Evaluate(problem.cage.vertices), 0);
  Points3d half = Points3d::Zero(3, problem.cage.vertices.cols());
  problem.term.AddHalfGradient(&half);
  EXPECT_EQ(half.norm(), 0);
  SurfaceBlocks blocks;
  blocks.SetZero(problem.m1->topology);
  problem.term.AddBlocks(&blocks);
  for (const Eigen::Matrix3f& block : blocks.vertex) EXPECT_EQ(block.norm(), 0);
}

TEST(ImageTermTest, IsOffWithoutTargetsOrWeights) {
  Problem problem({0, 0, 0});
  EXPECT_FALSE(problem.term.is_on());
  EXPECT_EQ(problem.term.Evaluate(problem.cage.vertices), 0);
  problem.term.SetTarget(nullptr, {1, 1, 1}, 0);
  EXPECT_FALSE(problem.term.is_on());
  const std::vector<ImageTarget> none;
  problem.term.SetTarget(&none, {1, 1, 1}, 0);
  EXPECT_FALSE(problem.term.is_on());
}

TEST(ImageTermTest, ViewsAreDrawnBySeedFrameAndIteration) {
  Problem problem({1, 0, 0}, {}, /*per_iteration=*/2);
  const Points3d& V = problem.cage.vertices;
  std::set<double> energies;
  for (int iteration = 0; iteration < 40; ++iteration) {
    problem.term.Draw(iteration);
    energies.insert(problem.term.Evaluate(V));
  }
  // 6 views have 15 pairs.
  EXPECT_GT(energies.size(), 10);
  EXPECT_LE(energies.size(), 15);
  problem.term.Draw(3);
  const double third = problem.term.Evaluate(V);
  problem.term.Draw(4);
  problem.term.Evaluate(V);
  problem.term.Draw(3);
  EXPECT_EQ(problem.term.Evaluate(V), third);
  // The mean over all pairs is the energy of all views.
  problem.term.UseAll();
  const double all = problem.term.Evaluate(V);
  double mean = 0;
  for (const double e : energies) mean += e / energies.size();
  EXPECT_NEAR(mean, all, 0.5 * all);
}

TEST(ImageTermTest, IsTheSameForAnyNumberOfThreads) {
  const auto run = [](int threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Problem problem({1, 0.5, 0.1});
    Points3d half = Points3d::Zero(3, problem.cage.vertices.cols());
    const double energy = problem.term.Evaluate(problem.cage.vertices);
    problem.term.AddHalfGradient(&half);
    return std::pair(energy, half);
  };
  EXPECT_EQ(run(1), run(2));
}

TEST(RefinedSurfaceTest, EdgesAreNumberedAsTheRendererNumbersThem) {
  const TriangleMesh mesh = Torus(12, 6);
  const RefinedSurface m1(*Topology::Create(mesh.vertices.cols(), mesh.triangles), CreaseTags());
  const MeshEdges edges(m1.topology.triangles());
  ASSERT_EQ(edges.size(), m1.topology.edge_count());
  for (int32_t e = 0; e < m1.topology.edge_count(); ++e) {
    EXPECT_EQ(edges.vertices(e), m1.topology.edge(e));
  }
}

// Images of the shape that the cage has, through cameras that are said to be elsewhere.
TEST(ImageTermTest, FindsByHowMuchACameraIsOff) {
  Problem problem({1, 0, 0});
  const Points3d& V = problem.cage.vertices;
  Points3d Q;
  ApplyStencils(problem.m1->position, V, &Q);
  const MeshEdges edges(problem.m1->topology.triangles());
  for (ImageTarget& target : problem.targets) {
    MeshView view;
    view.Render(Q, problem.m1->topology.triangles(), edges, target.camera, {});
    target.silhouette = view.silhouette();
    target.camera.cx += 1.5;
    target.camera.cy -= 1;
    target.slack = 3;
  }
  const auto energy_after = [&](int steps) {
    problem.term.SetTarget(&problem.targets, {1, 0, 0}, 0);
    for (int step = 0; step < steps; ++step) problem.term.Calibrate(V);
    return problem.term.Evaluate(V);
  };
  const double exact = energy_after(0);
  ASSERT_GT(exact, 1e-3);
  EXPECT_LT(energy_after(1), 0.3 * exact);
  EXPECT_LT(energy_after(5), 1e-6 * exact);
  // The gradient is that through the moved cameras: none is left.
  Points3d half_gradient = Points3d::Zero(3, V.cols()), before = half_gradient;
  problem.term.AddHalfGradient(&half_gradient);
  energy_after(0);
  problem.term.AddHalfGradient(&before);
  EXPECT_LT(half_gradient.norm(), 1e-2 * before.norm());
  // No farther than the slack, and not at all without it.
  for (ImageTarget& target : problem.targets) target.slack = 0.9;
  const double halfway = energy_after(5);
  EXPECT_NEAR(halfway / exact, std::pow((std::hypot(1.5, 1) - 0.9) / std::hypot(1.5, 1), 2), 0.1);
  for (ImageTarget& target : problem.targets) target.slack = 0;
  EXPECT_EQ(energy_after(5), exact);
}

}  // namespace
}  // namespace cagefit
