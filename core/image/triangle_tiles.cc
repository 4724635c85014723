#include "core/image/triangle_tiles.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/image/cross2.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 4096;
constexpr double kTrianglesPerTile = 8;
constexpr int kMostSide = 16;

}  // namespace

void TriangleTiles::Build(const ProjectedMesh& mesh, const Triangles& triangles, int width,
                          int height, double margin, int pad, int side) {
  const int64_t count = triangles.cols();
  if (side <= 0) {
    const double pixels = static_cast<double>(width) * height;
    side = static_cast<int>(std::sqrt(kTrianglesPerTile * pixels / std::max<int64_t>(1, count)));
    side = std::clamp(side, 1, std::max(kMostSide, std::max(width, height) / kMostSide));
  }
  side_ = side;
  pad_ = pad;
  columns_ = (width + 2 * pad + side - 1) / side;
  rows_ = (height + 2 * pad + side - 1) / side;
  ranges_.resize(count);
  const double per_pixel = 1.0 / side;
  const auto tile_of = [per_pixel](double x, int tiles) {
    // Outside the image by far may be beyond any integer. std::floor is a call without SSE 4.1.
    return static_cast<int16_t>(
        static_cast<int>(std::clamp(x * per_pixel, -1.0, static_cast<double>(tiles)) + 1) - 1);
  };
  ParallelFor(count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t f = begin; f < end; ++f) {
      Range& range = ranges_[f];
      range = {0, -1, 0, -1};
      if (!mesh.IsSeen(triangles, f)) continue;
      const auto a = mesh.points.col(triangles(0, f)), b = mesh.points.col(triangles(1, f)),
                 c = mesh.points.col(triangles(2, f));
      // Pixel i covers [i - 0.5, i + 0.5].
      const double low = pad + 0.5 - margin, high = pad + 0.5 + margin;
      const int16_t x0 = tile_of(std::min({a[0], b[0], c[0]}) + low, columns_),
                    x1 = tile_of(std::max({a[0], b[0], c[0]}) + high, columns_),
                    y0 = tile_of(std::min({a[1], b[1], c[1]}) + low, rows_),
                    y1 = tile_of(std::max({a[1], b[1], c[1]}) + high, rows_);
      range = {std::max<int16_t>(x0, 0), std::min<int16_t>(x1, static_cast<int16_t>(columns_ - 1)),
               std::max<int16_t>(y0, 0), std::min<int16_t>(y1, static_cast<int16_t>(rows_ - 1))};
    }
  });
  begin_.assign(tile_count() + 1, 0);
  const auto for_tiles = [this](const Range& r, const auto& body) {
    for (int64_t y = r.y0; y <= r.y1; ++y) {
      for (int64_t x = r.x0; x <= r.x1; ++x) body(y * columns_ + x);
    }
  };
  for (const Range& range : ranges_) {
    for_tiles(range, [this](int64_t t) { ++begin_[t + 1]; });
  }
  for (int64_t t = 0; t < tile_count(); ++t) begin_[t + 1] += begin_[t];
  triangles_.resize(begin_.back());
  for (int64_t f = 0; f < count; ++f) {
    for_tiles(ranges_[f],
              [this, f](int64_t t) { triangles_[begin_[t]++] = static_cast<int32_t>(f); });
  }
  // Each begin has moved to its tile's end.
  for (int64_t t = tile_count(); t > 0; --t) begin_[t] = begin_[t - 1];
  begin_[0] = 0;
}

absl::Span<const int32_t> TriangleTiles::Near(double x, double y) const {
  const double column = std::floor((x + pad_ + 0.5) / side_);
  const double row = std::floor((y + pad_ + 0.5) / side_);
  if (!(column >= 0 && row >= 0 && column < columns_ && row < rows_)) return {};
  return at(static_cast<int64_t>(row) * columns_ + static_cast<int64_t>(column));
}

bool IsCovered(const ProjectedMesh& mesh, const Triangles& triangles, const TriangleTiles& tiles,
               const Eigen::Vector2d& p) {
  for (const int32_t f : tiles.Near(p[0], p[1])) {
    const Eigen::Vector2d a = mesh.points.col(triangles(0, f)).head<2>() - p,
                          b = mesh.points.col(triangles(1, f)).head<2>() - p;
    const double ab = Cross2(a, b);
    const Eigen::Vector2d c = mesh.points.col(triangles(2, f)).head<2>() - p;
    const double bc = Cross2(b, c);
    if (ab * bc < 0) continue;
    const double ca = Cross2(c, a);
    if (bc * ca < 0 || ab * ca < 0) continue;
    if (ab != 0 || bc != 0 || ca != 0) return true;
  }
  return false;
}

}  // namespace cagefit
