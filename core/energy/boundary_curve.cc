#include "core/energy/boundary_curve.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 256;
constexpr double kRadiusPerSpacing = 3;  // some 54 points of a surface
constexpr int kFewestNeighbors = 6;      // fewer: a stray
constexpr int kFewestBeside = 3;         // others of the boundary around one of its points
// Most points lie amid their neighbours. Only every kStride-th is asked how far off their middle it
// is, in radii, and the points around those that are far off are looked at.
constexpr int64_t kStride = 4;
constexpr float kNearBoundary = 0.22f;
// kOpenAngle without any neighbour puts their middle 0.26 radii away.
constexpr float kLeastOffset = 0.18f;
constexpr float kSameSheet = 0.3f;  // cosine between normals
constexpr double kTwoPi = 2 * 3.14159265358979323846;

using Side = std::array<int32_t, 3>;                        // vertices, triangle
using Curve = std::vector<std::array<Eigen::Vector3f, 3>>;  // point, tangent, normal

BoundaryCurve Columns(const Curve& curve) {
  BoundaryCurve out;
  const auto K = static_cast<int64_t>(curve.size());
  for (Points3f* part : {&out.points, &out.tangents, &out.normals}) part->resize(3, K);
  for (int64_t k = 0; k < K; ++k) {
    out.points.col(k) = curve[k][0];
    out.tangents.col(k) = curve[k][1];
    out.normals.col(k) = curve[k][2];
  }
  return out;
}

// The first of the vertices at the same place: files repeat a vertex along seams.
std::vector<int32_t> Weld(const Points3d& vertices) {
  absl::flat_hash_map<std::array<double, 3>, int32_t> first;
  std::vector<int32_t> welded(vertices.cols());
  for (int32_t v = 0; v < vertices.cols(); ++v) {
    welded[v] =
        first.try_emplace({vertices(0, v), vertices(1, v), vertices(2, v)}, v).first->second;
  }
  return welded;
}

// Calls visit(j) for the points within `radius` of point i that face the same way, without i.
template <typename Visit>
void ForEachNeighbor(const CellGrid& grid, int64_t i, double radius, const Visit& visit) {
  const Eigen::Vector3f x = grid.point_at(i), n = grid.normal_at(i);
  const auto square = static_cast<float>(radius * radius);
  grid.ForEachRun(x.cast<double>(), radius, [&](int32_t begin, int32_t end) {
    for (int32_t j = begin; j < end; ++j) {
      if (j == i || (grid.point_at(j) - x).squaredNorm() > square) continue;
      if (n.dot(grid.normal_at(j)) > kSameSheet) visit(j);
    }
  });
}

// How far a point is from the middle of its neighbours, in radii.
float OffsetOf(const CellGrid& grid, int64_t i, double radius) {
  const Eigen::Vector3f x = grid.point_at(i);
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  int neighbors = 0;
  ForEachNeighbor(grid, i, radius, [&](int32_t j) {
    sum += grid.point_at(j) - x;
    ++neighbors;
  });
  return neighbors > 0 ? sum.norm() / (neighbors * static_cast<float>(radius)) : 0;
}

// Points that may be open, ascending.
std::vector<int32_t> Candidates(const CellGrid& grid, double radius) {
  const int64_t asked = (grid.size() + kStride - 1) / kStride;
  std::vector<char> is_near(asked), is_candidate(grid.size());
  ParallelFor(asked, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      is_near[k] = OffsetOf(grid, k * kStride, radius) > kNearBoundary;
    }
  });
  for (int64_t k = 0; k < asked; ++k) {
    if (is_near[k] == 0) continue;
    is_candidate[k * kStride] = 1;
    ForEachNeighbor(grid, k * kStride, radius, [&](int32_t j) { is_candidate[j] = 1; });
  }
  std::vector<int32_t> candidates;
  for (int32_t i = 0; i < grid.size(); ++i) {
    if (is_candidate[i] != 0) candidates.push_back(i);
  }
  return candidates;
}

bool IsOpen(const CellGrid& grid, int64_t i, double radius, std::vector<float>* angles) {
  if (OffsetOf(grid, i, radius) < kLeastOffset) return false;
  const Eigen::Vector3f x = grid.point_at(i), n = grid.normal_at(i);
  const Eigen::Vector3f a = n.unitOrthogonal(), b = n.cross(a);
  angles->clear();
  ForEachNeighbor(grid, i, radius, [&](int32_t j) {
    const Eigen::Vector3f d = grid.point_at(j) - x;
    angles->push_back(std::atan2(b.dot(d), a.dot(d)));
  });
  if (angles->size() < kFewestNeighbors) return false;
  std::sort(angles->begin(), angles->end());
  double gap = angles->front() - angles->back() + kTwoPi;
  for (size_t k = 1; k < angles->size(); ++k) {
    gap = std::max(gap, static_cast<double>((*angles)[k] - (*angles)[k - 1]));
  }
  return gap > kOpenAngle;
}

}  // namespace

BoundaryCurve BoundaryOfMesh(const TriangleMesh& mesh, double spacing) {
  const std::vector<int32_t> welded = Weld(mesh.vertices);
  std::vector<Side> sides;
  sides.reserve(mesh.triangles.size());
  for (int32_t f = 0; f < mesh.triangles.cols(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const int32_t i = welded[mesh.triangles(c, f)], j = welded[mesh.triangles((c + 1) % 3, f)];
      if (i != j) sides.push_back({std::min(i, j), std::max(i, j), f});
    }
  }
  std::sort(sides.begin(), sides.end());
  Curve curve;
  for (size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    const auto [i, j, f] = sides[begin];
    while (end < sides.size() && sides[end][0] == i && sides[end][1] == j) ++end;
    if (end - begin != 1) continue;
    const auto corners = mesh.triangles.col(f);
    const Eigen::Vector3d a = mesh.vertices.col(i), b = mesh.vertices.col(j);
    const Eigen::Vector3d o = mesh.vertices.col(corners(0));
    const Eigen::Vector3d normal =
        (mesh.vertices.col(corners(1)) - o).cross(mesh.vertices.col(corners(2)) - o).normalized();
    const double length = (b - a).norm();
    if (!(length > 0)) continue;
    const int parts = std::max(1, static_cast<int>(std::ceil(length / spacing)));
    for (int k = 0; k < parts; ++k) {
      const Eigen::Vector3d x = a + (k + 0.5) / parts * (b - a);
      curve.push_back({x.cast<float>(), ((b - a) / length).cast<float>(), normal.cast<float>()});
    }
  }
  return Columns(curve);
}

BoundaryCurve BoundaryOfCloud(const CellGrid& grid, double spacing) {
  const double radius = kRadiusPerSpacing * spacing;
  const std::vector<int32_t> candidates = Candidates(grid, radius);
  std::vector<char> is_open(grid.size());
  ParallelFor(static_cast<int64_t>(candidates.size()), kGrain, [&](int64_t begin, int64_t end) {
    std::vector<float> angles;
    for (int64_t k = begin; k < end; ++k) {
      is_open[candidates[k]] = IsOpen(grid, candidates[k], radius, &angles);
    }
  });
  Curve curve;
  std::vector<Eigen::Vector3f> around;
  for (const int32_t i : candidates) {
    if (is_open[i] == 0) continue;
    around.assign(1, grid.point_at(i));
    ForEachNeighbor(grid, i, radius, [&](int32_t j) {
      if (is_open[j] != 0) around.push_back(grid.point_at(j));
    });
    if (static_cast<int>(around.size()) <= kFewestBeside) continue;
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();
    for (const Eigen::Vector3f& x : around) mean += x;
    mean /= static_cast<float>(around.size());
    Eigen::Matrix3f spread = Eigen::Matrix3f::Zero();
    for (const Eigen::Vector3f& x : around) spread += (x - mean) * (x - mean).transpose();
    const Eigen::Vector3f tangent =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f>(spread).eigenvectors().col(2);
    curve.push_back({mean, tangent, grid.normal_at(i)});
  }
  return Columns(curve);
}

}  // namespace cagefit
