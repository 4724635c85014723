// The nearest triangle at every pixel centre.
#ifndef CAGEFIT_CORE_IMAGE_DEPTH_BUFFER_H_
#define CAGEFIT_CORE_IMAGE_DEPTH_BUFFER_H_

#include <cstdint>
#include <vector>

#include "core/image/image.h"
#include "core/image/triangle_tiles.h"

namespace cagefit {

// Not thread-safe. Buffers keep their capacity.
class DepthBuffer {
 public:
  static constexpr int32_t kNone = -1;

  // `tiles` were built without margin from the same mesh for width x height pixels. A triangle
  // holds the pixel centres on its edges, too; of several at one depth the first is the nearest.
  // Triangles of no area hold none.
  void Render(const ProjectedMesh& mesh, const Triangles& triangles, const TriangleTiles& tiles,
              int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  bool IsCovered(int x, int y) const { return triangle(x, y) != kNone; }
  int32_t triangle(int x, int y) const { return triangle_[static_cast<size_t>(y) * width_ + x]; }
  // Depth of that triangle at the pixel's centre.
  double depth(int x, int y) const {
    return 1 / inverse_depth_[static_cast<size_t>(y) * width_ + x];
  }

 private:
  void RenderTile(const ProjectedMesh& mesh, const Triangles& triangles, const TriangleTiles& tiles,
                  int64_t tile);

  int width_ = 0, height_ = 0;
  std::vector<int32_t> triangle_;
  std::vector<double> inverse_depth_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_DEPTH_BUFFER_H_
