#include "core/image/outline_silhouette.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/image/cross2.h"
#include "core/image/silhouette_image.h"

namespace cagefit {

namespace {

constexpr int64_t kRowGrain = 16;
// Sine of the angle between two edges below which their crossing is not followed: it would move
// without bound.
constexpr double kLeastSine = 1e-3;

double Sigmoid(double x) { return 1 / (1 + std::exp(-x)); }

Eigen::Vector2d Normal(const Eigen::Vector2d& along) {
  return Eigen::Vector2d(-along[1], along[0]).normalized();
}

// Edge e as a + t along.
void Ends(const ProjectedMesh& mesh, const MeshEdges& edges, int32_t e, Eigen::Vector2d* a,
          Eigen::Vector2d* along) {
  const auto& [va, vb] = edges.vertices(e);
  *a = mesh.points.col(va).head<2>();
  *along = mesh.points.col(vb).head<2>() - *a;
}

}  // namespace

void OutlineSilhouette::Render(const ProjectedMesh& mesh, const Triangles& triangles,
                               const MeshEdges& edges, const TriangleTiles& tiles, int width,
                               int height, double sigma, Image* silhouette) {
  const double half_side = 0.5 * std::min(width, height);
  const double reach = SilhouetteReach(sigma, half_side);
  const double variance = sigma * half_side * half_side;  // pixels^2
  outline_.Find(mesh, triangles, edges, tiles, width, height, reach);
  MeasureOutline(outline_.outline(), width, height, reach, &distance_);
  if (silhouette->width != width || silhouette->height != height || silhouette->channels != 1) {
    *silhouette = Image(width, height);
  }
  inside_.resize(static_cast<size_t>(width) * height);
  found_.resize((height + kRowGrain - 1) / kRowGrain);
  ParallelFor(height, kRowGrain, [&](int64_t begin, int64_t end) {
    std::vector<Row>& rows = found_[begin / kRowGrain];
    rows.clear();
    const auto is_covered = [&](const Eigen::Vector2d& p) {
      return IsCovered(mesh, triangles, tiles, p);
    };
    for (auto y = static_cast<int>(begin); y < static_cast<int>(end); ++y) {
      for (int x = 0; x < width; ++x) {
        const int32_t pixel = y * width + x;
        const Eigen::Vector2d p(x, y);
        const int32_t k = distance_.segment[pixel];
        if (k < 0) {
          // Between pixels that the outline is not near to, there is none.
          const bool follows = x > 0 && reach >= 1;
          inside_[pixel] = follows ? inside_[pixel - 1] : is_covered(p);
          *silhouette->at(x, y) = inside_[pixel];
          continue;
        }
        const Foot foot = FootOf(mesh, edges, pixel, p);
        const double beside = outline_.side(outline_.pieces()[k]) * Cross2(foot.along, p - foot.a);
        inside_[pixel] = foot.end == 0 ? beside > 0 : is_covered(p);
        const double d = distance_.distance[pixel];
        const double value = Sigmoid((inside_[pixel] != 0 ? d : -d) * d / variance);
        *silhouette->at(x, y) = static_cast<float>(value);
        if (d > 0) AddRows(mesh, edges, pixel, p, foot, value, variance, &rows);
      }
    }
  });
  rows_.clear();
  for (const std::vector<Row>& rows : found_) rows_.insert(rows_.end(), rows.begin(), rows.end());
}

OutlineSilhouette::Foot OutlineSilhouette::FootOf(const ProjectedMesh& mesh, const MeshEdges& edges,
                                                  int32_t pixel, const Eigen::Vector2d& p) const {
  const MeshOutline::Piece& piece = outline_.pieces()[distance_.segment[pixel]];
  Foot foot;
  Ends(mesh, edges, piece.edge, &foot.a, &foot.along);
  const double free = (p - foot.a).dot(foot.along) / foot.along.squaredNorm();
  foot.t = std::clamp(free, piece.t0, piece.t1);
  foot.end = free < piece.t0 ? -1 : free > piece.t1 ? 1 : 0;
  return foot;
}

void OutlineSilhouette::AddRows(const ProjectedMesh& mesh, const MeshEdges& edges, int32_t pixel,
                                const Eigen::Vector2d& p, const Foot& foot, double value,
                                double variance, std::vector<Row>* rows) const {
  const MeshOutline::Piece& piece = outline_.pieces()[distance_.segment[pixel]];
  const Eigen::Vector2d from = p - (foot.a + foot.t * foot.along);
  const double d = from.norm();
  if (!(d > 0)) return;
  const double slope = value * (1 - value) * 2 * d / variance;
  const Eigen::Vector2d by_point = (IsInside(pixel) ? -slope : slope) / d * from;
  const int32_t crossing = foot.end < 0 ? piece.crossing0 : foot.end > 0 ? piece.crossing1 : -1;
  if (crossing >= 0) {
    Eigen::Vector2d e, across;
    Ends(mesh, edges, crossing, &e, &across);
    Eigen::Matrix2d M;
    M << Normal(foot.along).transpose(), Normal(across).transpose();
    if (std::abs(M.determinant()) >= kLeastSine) {
      const double u =
          std::clamp(Cross2(e - foot.a, foot.along) / Cross2(foot.along, across), 0.0, 1.0);
      const Eigen::Vector2d share = M.transpose().inverse() * by_point;
      rows->push_back({pixel, piece.edge, foot.t, share[0] * M.row(0).transpose(), 2});
      rows->push_back({pixel, crossing, u, share[1] * M.row(1).transpose(), 2});
      return;
    }
  }
  rows->push_back({pixel, piece.edge, foot.t, by_point, 1});
}

void OutlineSilhouette::AddGradient(const MeshEdges& edges, const Image& by_silhouette,
                                    Points2d* by_vertex) const {
  for (const Row& row : rows_) {
    const double seed = by_silhouette.values[row.pixel];
    if (seed == 0) continue;
    const auto& [a, b] = edges.vertices(row.edge);
    by_vertex->col(a) += seed * (1 - row.t) * row.by_point;
    by_vertex->col(b) += seed * row.t * row.by_point;
  }
}

}  // namespace cagefit
