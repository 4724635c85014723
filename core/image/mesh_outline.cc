#include "core/image/mesh_outline.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/image/cross2.h"

namespace cagefit {

namespace {

constexpr int64_t kEdgeGrain = 8192, kFoldGrain = 128;
// Pixels beside an edge at which its other side is looked at.
constexpr double kAside = 1e-6;
constexpr double kFoldsPerBin = 2;
constexpr double kLeastBin = 1;  // pixels

Eigen::Vector2d At(const ProjectedMesh& mesh, int32_t vertex) {
  return mesh.points.col(vertex).head<2>();
}

// +1 or -1 where all triangles of the edge are on that side of it, else 0.
int8_t SideOfAll(const std::vector<int8_t>& turn, const MeshEdges& edges, int64_t e) {
  int8_t side = 0;
  for (const MeshEdges::Side& s : edges.sides(e)) {
    const auto sign = static_cast<int8_t>(turn[s.triangle] * s.direction);
    if (sign == 0) continue;
    if (side == -sign) return 0;
    side = sign;
  }
  return side;
}

// The part of a + t (b - a), 0 <= t <= 1, inside the box; false where there is none.
bool ClipToBox(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& low,
               const Eigen::Vector2d& high, double* t0, double* t1) {
  *t0 = 0;
  *t1 = 1;
  for (int k = 0; k < 2; ++k) {
    const double d = b[k] - a[k];
    if (d == 0) {
      if (a[k] < low[k] || a[k] > high[k]) return false;
      continue;
    }
    const double s = (low[k] - a[k]) / d, e = (high[k] - a[k]) / d;
    *t0 = std::max(*t0, std::min(s, e));
    *t1 = std::min(*t1, std::max(s, e));
  }
  return *t0 < *t1;
}

}  // namespace

bool CrossSegments(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& d,
                   const Eigen::Vector2d& e, double* t, double* u) {
  const Eigen::Vector2d ab = b - a, de = e - d, ad = d - a;
  const double denominator = Cross2(ab, de);
  if (denominator == 0) return false;
  *t = Cross2(ad, de) / denominator;
  *u = Cross2(ad, ab) / denominator;
  return *t > 0 && *t < 1 && *u > 0 && *u < 1;
}

void MeshOutline::Find(const ProjectedMesh& mesh, const Triangles& triangles,
                       const MeshEdges& edges, const TriangleTiles& tiles, int width, int height,
                       double reach) {
  low_ = Eigen::Vector2d::Constant(-reach);
  high_ = Eigen::Vector2d(width - 1 + reach, height - 1 + reach);
  FindFolds(mesh, triangles, edges);
  BinFolds(mesh, edges);
  const auto count = static_cast<int64_t>(folds_.size());
  found_.resize((count + kFoldGrain - 1) / kFoldGrain);
  ParallelFor(count, kFoldGrain, [&](int64_t begin, int64_t end) {
    std::vector<Piece>& pieces = found_[begin / kFoldGrain];
    pieces.clear();
    std::vector<Cut> cuts;
    for (int64_t k = begin; k < end; ++k) {
      CutFold(mesh, edges, folds_[k], &cuts);
      KeepOuter(mesh, triangles, edges, tiles, folds_[k], cuts, &pieces);
    }
  });
  pieces_.clear();
  for (const std::vector<Piece>& pieces : found_) {
    pieces_.insert(pieces_.end(), pieces.begin(), pieces.end());
  }
  const auto size = static_cast<int64_t>(pieces_.size());
  outline_.points.resize(2, 2 * size);
  outline_.segments.resize(2, size);
  for (int64_t k = 0; k < size; ++k) {
    const auto& [a, b] = edges.vertices(pieces_[k].edge);
    const Eigen::Vector2d origin = At(mesh, a), along = At(mesh, b) - origin;
    outline_.points.col(2 * k) = origin + pieces_[k].t0 * along;
    outline_.points.col(2 * k + 1) = origin + pieces_[k].t1 * along;
    outline_.segments.col(k) << static_cast<int32_t>(2 * k), static_cast<int32_t>(2 * k + 1);
  }
}

void MeshOutline::FindFolds(const ProjectedMesh& mesh, const Triangles& triangles,
                            const MeshEdges& edges) {
  turn_.resize(triangles.cols());
  ParallelFor(triangles.cols(), kEdgeGrain, [&](int64_t begin, int64_t end) {
    for (int64_t f = begin; f < end; ++f) {
      turn_[f] = 0;
      if (!mesh.IsSeen(triangles, f)) continue;
      const Eigen::Vector2d a = At(mesh, triangles(0, f));
      const double area = Cross2(At(mesh, triangles(1, f)) - a, At(mesh, triangles(2, f)) - a);
      turn_[f] = static_cast<int8_t>((area > 0) - (area < 0));
    }
  });
  side_.resize(edges.size());
  ParallelFor(edges.size(), kEdgeGrain, [&](int64_t begin, int64_t end) {
    for (int64_t e = begin; e < end; ++e) side_[e] = SideOfAll(turn_, edges, e);
  });
  folds_.clear();
  for (int64_t e = 0; e < edges.size(); ++e) {
    if (side_[e] == 0) continue;
    double t0, t1;
    const auto& [a, b] = edges.vertices(e);
    if (!ClipToBox(At(mesh, a), At(mesh, b), low_, high_, &t0, &t1)) continue;
    folds_.push_back(static_cast<int32_t>(e));
  }
}

template <typename Body>
void MeshOutline::ForBins(const ProjectedMesh& mesh, const MeshEdges& edges, int32_t edge,
                          const Body& body) const {
  const auto& [va, vb] = edges.vertices(edge);
  Eigen::Vector2d a = At(mesh, va), b = At(mesh, vb);
  double t0, t1;
  ClipToBox(a, b, low_, high_, &t0, &t1);
  const Eigen::Vector2d along = b - a;
  b = a + t1 * along;
  a += t0 * along;
  if (a[1] > b[1]) a.swap(b);
  const auto bin = [this](double x, int axis, int count) {
    return std::clamp(static_cast<int>((x - low_[axis]) / bin_side_), 0, count - 1);
  };
  const int row0 = bin(a[1], 1, bin_rows_), row1 = bin(b[1], 1, bin_rows_);
  for (int row = row0; row <= row1; ++row) {
    // What of the segment lies in this row.
    double x0 = a[0], x1 = b[0];
    if (row0 != row1) {
      const double slope = (b[0] - a[0]) / (b[1] - a[1]);
      if (row > row0) x0 = a[0] + (low_[1] + row * bin_side_ - a[1]) * slope;
      if (row < row1) x1 = a[0] + (low_[1] + (row + 1) * bin_side_ - a[1]) * slope;
    }
    // A bin wider on either side where rounding could say otherwise for the other edge.
    constexpr double kSlack = 1e-6;
    const int column0 = bin(std::min(x0, x1) - kSlack, 0, bin_columns_),
              column1 = bin(std::max(x0, x1) + kSlack, 0, bin_columns_);
    for (int column = column0; column <= column1; ++column) body(row * bin_columns_ + column);
  }
}

void MeshOutline::BinFolds(const ProjectedMesh& mesh, const MeshEdges& edges) {
  const Eigen::Vector2d size = high_ - low_;
  const double folds = std::max<double>(1, static_cast<double>(folds_.size()));
  bin_side_ = std::max(kLeastBin, 0.25 * std::sqrt(kFoldsPerBin * size.prod() / folds));
  bin_columns_ = static_cast<int>(size[0] / bin_side_) + 1;
  bin_rows_ = static_cast<int>(size[1] / bin_side_) + 1;
  bin_begin_.assign(static_cast<size_t>(bin_columns_) * bin_rows_ + 1, 0);
  for (const int32_t e : folds_) {
    ForBins(mesh, edges, e, [this](int bin) { ++bin_begin_[bin + 1]; });
  }
  for (size_t k = 1; k < bin_begin_.size(); ++k) bin_begin_[k] += bin_begin_[k - 1];
  bin_folds_.resize(bin_begin_.back());
  for (const int32_t e : folds_) {
    ForBins(mesh, edges, e, [this, e](int bin) { bin_folds_[bin_begin_[bin]++] = e; });
  }
  // Each begin has moved to its bin's end.
  for (size_t k = bin_begin_.size() - 1; k > 0; --k) bin_begin_[k] = bin_begin_[k - 1];
  bin_begin_[0] = 0;
}

void MeshOutline::CutFold(const ProjectedMesh& mesh, const MeshEdges& edges, int32_t edge,
                          std::vector<Cut>* cuts) const {
  cuts->clear();
  const int32_t a = edges.vertices(edge)[0], b = edges.vertices(edge)[1];
  const Eigen::Vector2d A = At(mesh, a), B = At(mesh, b);
  ForBins(mesh, edges, edge, [&](int bin) {
    for (int32_t k = bin_begin_[bin]; k < bin_begin_[bin + 1]; ++k) {
      const int32_t other = bin_folds_[k];
      const auto& [d, e] = edges.vertices(other);
      if (other == edge || a == d || a == e || b == d || b == e) continue;
      double t, u;
      // One formula for both edges of a pair.
      const bool crosses = edge < other ? CrossSegments(A, B, At(mesh, d), At(mesh, e), &t, &u)
                                        : CrossSegments(At(mesh, d), At(mesh, e), A, B, &u, &t);
      if (crosses) cuts->push_back({t, other});
    }
  });
  std::sort(cuts->begin(), cuts->end(), [](const Cut& x, const Cut& y) {
    return x.t < y.t || (x.t == y.t && x.edge < y.edge);
  });
  // Two edges may meet in several bins.
  cuts->erase(std::unique(cuts->begin(), cuts->end(),
                          [](const Cut& x, const Cut& y) { return x.edge == y.edge; }),
              cuts->end());
}

void MeshOutline::KeepOuter(const ProjectedMesh& mesh, const Triangles& triangles,
                            const MeshEdges& edges, const TriangleTiles& tiles, int32_t edge,
                            const std::vector<Cut>& cuts, std::vector<Piece>* pieces) const {
  const auto& [a, b] = edges.vertices(edge);
  const Eigen::Vector2d origin = At(mesh, a), along = At(mesh, b) - origin;
  const Eigen::Vector2d outward = side_[edge] * Eigen::Vector2d(along[1], -along[0]).normalized();
  double first, last;
  ClipToBox(origin, At(mesh, b), low_, high_, &first, &last);
  Cut from{first, -1};
  bool joined = false;  // the piece before ends where this one begins
  for (size_t k = 0; k <= cuts.size(); ++k) {
    Cut to = k < cuts.size() ? cuts[k] : Cut{last, -1};
    if (to.t <= from.t && k < cuts.size()) {
      from = to.t > first ? to : from;
      continue;
    }
    to.t = std::min(to.t, last);
    if (from.t >= last) break;
    const Eigen::Vector2d middle = origin + 0.5 * (from.t + to.t) * along;
    if (IsCovered(mesh, triangles, tiles, middle + kAside * outward)) {
      joined = false;
    } else if (joined) {
      pieces->back().t1 = to.t;
      pieces->back().crossing1 = to.t < last ? to.edge : -1;
    } else {
      pieces->push_back({edge, from.t, to.t, from.edge, to.t < last ? to.edge : -1});
      joined = true;
    }
    from = to;
  }
}

}  // namespace cagefit
