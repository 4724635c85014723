// Which triangles touch which square tile of an image.
#ifndef CAGEFIT_CORE_IMAGE_TRIANGLE_TILES_H_
#define CAGEFIT_CORE_IMAGE_TRIANGLE_TILES_H_

#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "core/image/projected_mesh.h"

namespace cagefit {

// Not thread-safe while it is built. Buffers keep their capacity.
class TriangleTiles {
 public:
  // Tiles of `side` pixels, 0: by the number of triangles, so that few meet in a tile, from `pad`
  // pixels outside the image on. A triangle is listed where its bounding box, grown by `margin`
  // pixels, reaches; those that are not seen are left out. Within a tile triangles are in order of
  // index.
  void Build(const ProjectedMesh& mesh, const Triangles& triangles, int width, int height,
             double margin, int pad = 0, int side = 0);

  int side() const { return side_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int64_t tile_count() const { return static_cast<int64_t>(columns_) * rows_; }
  int64_t entry_count() const { return static_cast<int64_t>(triangles_.size()); }
  // First pixel of tile t = row * columns + column.
  int left(int64_t t) const { return static_cast<int>(t % columns_) * side_ - pad_; }
  int top(int64_t t) const { return static_cast<int>(t / columns_) * side_ - pad_; }
  // Entries of tile t.
  int32_t begin(int64_t t) const { return begin_[t]; }
  int32_t triangle(int64_t entry) const { return triangles_[entry]; }
  absl::Span<const int32_t> at(int64_t t) const {
    return absl::MakeConstSpan(triangles_).subspan(begin_[t], begin_[t + 1] - begin_[t]);
  }
  // Triangles near pixel coordinates (x, y); none outside the tiles.
  absl::Span<const int32_t> Near(double x, double y) const;

 private:
  struct Range {
    int16_t x0, x1, y0, y1;  // tiles, inclusive; x0 > x1: none
  };

  int side_ = 1, pad_ = 0, columns_ = 0, rows_ = 0;
  std::vector<Range> ranges_;
  std::vector<int32_t> begin_, triangles_;
};

// Whether a triangle holds pixel coordinates p, its edges included. `tiles` were built from the
// same mesh without margin and hold p; triangles of no area hold nothing.
bool IsCovered(const ProjectedMesh& mesh, const Triangles& triangles, const TriangleTiles& tiles,
               const Eigen::Vector2d& p);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_TRIANGLE_TILES_H_
