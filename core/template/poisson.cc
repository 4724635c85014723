#include "core/template/poisson.h"

#include <open3d/geometry/PointCloud.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/utility/Logging.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/base/parallel.h"
#include "core/cloud/cell_grid.h"
#include "core/cloud/kd_tree.h"
#include "core/cloud/noise.h"
#include "core/cloud/outliers.h"
#include "core/cloud/spacing.h"
#include "core/mesh/topology.h"
#include "core/template/mesh_repair.h"
#include "core/template/surface_cut.h"

namespace cagefit {

namespace {

constexpr double kGridSpacings = 8;  // cell of the grid in which outliers are looked for
constexpr int kTrimRounds = 20;      // of smoothing: some four cells far
constexpr double kTrimLevel = 0.6;   // of the reach: smoothing spreads what lies beyond inwards
constexpr double kMostReaches = 3;   // beyond, one distance counts as much as another
constexpr int kLeastDepth = 5, kMostDepth = 10;
constexpr int kBoundaryRounds = 3;
constexpr int64_t kGrain = 1024;

PointCloud WithoutOutliers(const PointCloud& cloud, double spacing) {
  PointCloud clean = cloud;
  if (!(spacing > 0)) return clean;
  CellGrid grid;
  grid.Build(cloud, kGridSpacings * spacing);
  RemovePoints(FindOutliers(grid), &clean);
  return clean;
}

absl::StatusOr<TriangleMesh> RunPoisson(const PointCloud& cloud, int depth) try {
  open3d::utility::VerbosityContextManager quiet(open3d::utility::VerbosityLevel::Error);
  quiet.Enter();
  open3d::geometry::PointCloud points;
  points.points_.resize(cloud.size());
  points.normals_.resize(cloud.size());
  for (int64_t i = 0; i < cloud.size(); ++i) {
    points.points_[i] = cloud.points.col(i).cast<double>();
    points.normals_[i] = cloud.normals.col(i).cast<double>().normalized();
  }
  const auto [mesh, densities] =
      open3d::geometry::TriangleMesh::CreateFromPointCloudPoisson(points, depth, 0, 1.1f, false, 1);
  quiet.Exit();
  TriangleMesh out;
  out.vertices.resize(3, static_cast<int64_t>(mesh->vertices_.size()));
  for (size_t v = 0; v < mesh->vertices_.size(); ++v) {
    out.vertices.col(static_cast<int64_t>(v)) = mesh->vertices_[v];
  }
  out.triangles.resize(3, static_cast<int64_t>(mesh->triangles_.size()));
  for (size_t f = 0; f < mesh->triangles_.size(); ++f) {
    out.triangles.col(static_cast<int64_t>(f)) = mesh->triangles_[f];
  }
  if (out.triangles.cols() == 0) {
    return absl::FailedPreconditionError("template: screened Poisson gave no triangles");
  }
  return out;
} catch (const std::exception& error) {
  return absl::FailedPreconditionError(
      absl::StrFormat("template: screened Poisson failed: %s", error.what()));
}

// Distance of every vertex to the points, evened out over the surface so that its level lines run
// smoothly along the rim of the points.
Eigen::ArrayXd SmoothDistance(const TriangleMesh& mesh, const KdTree& tree, double most) {
  const int64_t n = mesh.vertices.cols();
  Eigen::ArrayXd distance(n);
  ParallelFor(n, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t v = begin; v < end; ++v) {
      int32_t index = 0;
      float squared = 0;
      tree.Nearest(mesh.vertices.col(v).cast<float>(), 1, &index, &squared);
      distance[v] = std::min(most, std::sqrt(static_cast<double>(squared)));
    }
  });
  Eigen::ArrayXd sum(n), weight(n);
  for (int round = 0; round < kTrimRounds; ++round) {
    sum = distance;
    weight.setOnes();
    for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
      for (int c = 0; c < 3; ++c) {
        const int32_t v = mesh.triangles(c, f), w = mesh.triangles((c + 1) % 3, f);
        sum[v] += distance[w];
        weight[v] += 1;
      }
    }
    distance = sum / weight;
  }
  return distance;
}

// Triangles that hang on by one edge make a boundary ragged.
TriangleMesh WithoutSpikes(TriangleMesh mesh) {
  for (int round = 0; round < 3; ++round) {
    const auto topology =
        Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles);
    if (!topology.ok()) return mesh;
    std::vector<char> keep(mesh.triangles.cols(), 1);
    int64_t spikes = 0;
    for (int32_t f = 0; f < topology->triangle_count(); ++f) {
      int open = 0;
      for (int c = 0; c < 3; ++c) open += topology->opposite(3 * f + c) == Topology::kNone;
      if (open >= 2) keep[f] = 0, ++spikes;
    }
    if (spikes == 0) return mesh;
    RepairReport ignored;
    mesh = MakeManifold(SelectTriangles(mesh, keep), &ignored);
  }
  return mesh;
}

// Closes loops shorter than `length` with a fan around their middle.
TriangleMesh WithoutSmallHoles(const TriangleMesh& mesh, double length) {
  const auto topology =
      Topology::Create(static_cast<int32_t>(mesh.vertices.cols()), mesh.triangles);
  if (!topology.ok()) return mesh;
  std::vector<std::vector<int32_t>> small;
  int64_t fans = 0;
  for (std::vector<int32_t>& loop : topology->BoundaryLoops()) {
    double perimeter = 0;
    for (size_t k = 0; k < loop.size(); ++k) {
      perimeter +=
          (mesh.vertices.col(loop[k]) - mesh.vertices.col(loop[(k + 1) % loop.size()])).norm();
    }
    if (perimeter >= length) continue;
    fans += static_cast<int64_t>(loop.size());
    small.push_back(std::move(loop));
  }
  TriangleMesh out = mesh;
  int64_t v = mesh.vertices.cols(), f = mesh.triangles.cols();
  out.vertices.conservativeResize(3, v + static_cast<int64_t>(small.size()));
  out.triangles.conservativeResize(3, f + fans);
  for (const std::vector<int32_t>& loop : small) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const int32_t i : loop) middle += mesh.vertices.col(i);
    out.vertices.col(v) = middle / static_cast<double>(loop.size());
    for (size_t k = 0; k < loop.size(); ++k) {
      out.triangles.col(f++) << loop[(k + 1) % loop.size()], loop[k], static_cast<int32_t>(v);
    }
    ++v;
  }
  return out;
}

// Trimming cuts along whole triangles; a few rounds of the curve's own mask take the steps out.
void SmoothBoundary(TriangleMesh* mesh) {
  const auto topology =
      Topology::Create(static_cast<int32_t>(mesh->vertices.cols()), mesh->triangles);
  if (!topology.ok()) return;
  const std::vector<std::vector<int32_t>> loops = topology->BoundaryLoops();
  for (int round = 0; round < kBoundaryRounds; ++round) {
    const Points3d V = mesh->vertices;
    for (const std::vector<int32_t>& loop : loops) {
      const size_t n = loop.size();
      for (size_t k = 0; k < n; ++k) {
        mesh->vertices.col(loop[k]) =
            0.5 * V.col(loop[k]) + 0.25 * (V.col(loop[(k + 1) % n]) + V.col(loop[(k + n - 1) % n]));
      }
    }
  }
}

// Depth of the octree. Its cells are half as wide as the points are apart, so that folds keep their
// two sides; no finer than the noise, which would grow bubbles; and no finer than a few per control
// edge.
int Depth(const PointCloud& cloud, double spacing, double longest, int32_t control_vertices) {
  CellGrid grid;
  grid.Build(cloud, kGridSpacings * spacing);
  const double noise = EstimateNoise(grid).sigma;
  const double by_points = std::log2(2 * longest / spacing);
  const double by_noise = std::log2(longest / std::max(noise, 1e-30));
  const double by_vertices = std::log2(4.2 * std::sqrt(static_cast<double>(control_vertices)));
  const double depth = std::min({by_points, by_noise, by_vertices});
  return std::clamp(static_cast<int>(std::lround(depth)), kLeastDepth, kMostDepth);
}

}  // namespace

absl::StatusOr<TriangleMesh> ReconstructPoisson(const PointCloud& cloud, int32_t control_vertices) {
  if (!cloud.has_normals()) return absl::InvalidArgumentError("template: the cloud has no normals");
  const PointCloud clean =
      WithoutOutliers(cloud, MedianSpacing(cloud.points, KdTree(cloud.points)));
  const KdTree tree(clean.points);
  const double spacing = MedianSpacing(clean.points, tree);
  const double longest = BoundingBox(clean.points).size().maxCoeff();
  if (!(spacing > 0) || !(longest > 0)) {
    return absl::FailedPreconditionError("template: most points of the cloud coincide");
  }
  const int depth = Depth(clean, spacing, longest, control_vertices);
  absl::StatusOr<TriangleMesh> surface = RunPoisson(clean, depth);
  if (!surface.ok()) return surface.status();

  const double cell = 1.1 * longest / std::exp2(depth);
  const double reach = 2 * std::max(spacing, cell);
  RepairReport ignored;
  TriangleMesh mesh = MakeManifold(
      CutBelow(*surface, SmoothDistance(*surface, tree, kMostReaches * reach), kTrimLevel * reach),
      &ignored);
  if (mesh.triangles.cols() == 0) {
    return absl::FailedPreconditionError("template: trimming left nothing of the Poisson surface");
  }
  mesh = WithoutSpikes(WithoutSmallHoles(mesh, 16 * reach));
  mesh = MakeManifold(mesh, &ignored);
  SmoothBoundary(&mesh);
  return mesh;
}

}  // namespace cagefit
