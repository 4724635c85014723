#include "core/image/depth_buffer.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/image/cross2.h"

namespace cagefit {

namespace {

constexpr int64_t kTileGrain = 64;

// For -1 <= x: the library's need a call without SSE 4.1.
int FloorOf(double x) { return static_cast<int>(x + 1) - 1; }
int CeilOf(double x) { return (1 << 20) - static_cast<int>((1 << 20) - x); }

}  // namespace

void DepthBuffer::Render(const ProjectedMesh& mesh, const Triangles& triangles,
                         const TriangleTiles& tiles, int width, int height) {
  width_ = width;
  height_ = height;
  triangle_.assign(static_cast<size_t>(width) * height, kNone);
  inverse_depth_.assign(static_cast<size_t>(width) * height, 0);
  ParallelFor(tiles.tile_count(), kTileGrain, [&](int64_t begin, int64_t end) {
    for (int64_t t = begin; t < end; ++t) RenderTile(mesh, triangles, tiles, t);
  });
}

void DepthBuffer::RenderTile(const ProjectedMesh& mesh, const Triangles& triangles,
                             const TriangleTiles& tiles, int64_t tile) {
  const int left = std::max(0, tiles.left(tile)), top = std::max(0, tiles.top(tile));
  const int right = std::min(tiles.left(tile) + tiles.side(), width_) - 1;
  const int bottom = std::min(tiles.top(tile) + tiles.side(), height_) - 1;
  for (const int32_t f : tiles.at(tile)) {
    const Eigen::Vector3d a = mesh.points.col(triangles(0, f)),
                          b = mesh.points.col(triangles(1, f)),
                          c = mesh.points.col(triangles(2, f));
    const double area = Cross2((b - a).head<2>(), (c - a).head<2>());
    if (area == 0) continue;
    const int x0 = CeilOf(std::max<double>(left, std::min({a[0], b[0], c[0]}))),
              x1 = FloorOf(std::min<double>(right, std::max({a[0], b[0], c[0]}))),
              y0 = CeilOf(std::max<double>(top, std::min({a[1], b[1], c[1]}))),
              y1 = FloorOf(std::min<double>(bottom, std::max({a[1], b[1], c[1]})));
    if (x0 > x1 || y0 > y1) continue;
    const double scale = 1 / area, za = 1 / a[2], zb = 1 / b[2], zc = 1 / c[2];
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const Eigen::Vector2d p(x, y);
        const double wa = scale * Cross2(b.head<2>() - p, c.head<2>() - p),
                     wb = scale * Cross2(c.head<2>() - p, a.head<2>() - p), wc = 1 - wa - wb;
        if (wa < 0 || wb < 0 || wc < 0) continue;
        // 1/z is linear in the image.
        const double inverse = wa * za + wb * zb + wc * zc;
        const size_t at = static_cast<size_t>(y) * width_ + x;
        if (inverse <= inverse_depth_[at]) continue;
        inverse_depth_[at] = inverse;
        triangle_[at] = f;
      }
    }
  }
}

}  // namespace cagefit
