// The soft silhouette of PyTorch3D [ravi2020], with the same settings and meaning:
//
//   A(p) = 1 - prod_j (1 - sigmoid(-s_j(p) / sigma))
//
// s_j the squared distance, in normalised device coordinates (unit: half the smaller image side),
// from pixel centre p to projected triangle j, negative inside; over the triangles that hold p or
// have s_j < blur_radius, of these the faces_per_pixel nearest in depth at barycentric coordinates
// that are perspective-correct and clamped, ties by face index. Triangles whose projection has
// twice an area of at most 1e-8 (same units) are left out.
//
// The image is dilated, the more the finer the mesh: outline_silhouette.h has no such bias.
//
//   dA/ds_j = -(1 - A) (1 - sigmoid(s_j / sigma)) / sigma,   ds_j/dc = -+ 2 (p - c)
//
// with c = (1 - t) a + t b the nearest point of the triangle's outline, on edge (a, b).
#ifndef CAGEFIT_CORE_IMAGE_SOFT_SILHOUETTE_H_
#define CAGEFIT_CORE_IMAGE_SOFT_SILHOUETTE_H_

#include <array>
#include <cmath>
#include <vector>

#include "core/image/image.h"
#include "core/image/outline.h"
#include "core/image/triangle_tiles.h"

namespace cagefit {

struct SoftTile;

struct SoftSilhouetteOptions {
  double sigma = 1e-4;
  double blur_radius = std::log(1 / 1e-4 - 1) * 1e-4;  // squared distance
  int faces_per_pixel = 100;
};

// Not thread-safe. Buffers keep their capacity. Single precision; the same to the bit for any
// number of threads on one instruction set.
class SoftSilhouette {
 public:
  // Refers to nothing of its arguments afterwards.
  void Render(const ProjectedMesh& mesh, const Triangles& triangles, int width, int height,
              const SoftSilhouetteOptions& options, Image* silhouette);

  // Adds dE/d(x, y) of every vertex (2 x n, per pixel of length) given dE/dA at the last rendering.
  // A pixel whose A is 1 to 1e-8 costs nothing.
  void AddGradient(const Triangles& triangles, const Image& by_silhouette, Points2d* by_vertex);

  // An edge of a triangle in the coordinates of a tile, prepared for many pixels.
  struct Side {
    float line[3];   // line . (x, y, 1): distance to the line, positive inside
    float along[3];  // along . (x, y, 1): coordinate along the edge, 0 at its first corner
    float length, inverse_length;
  };
  struct TileTriangle {
    Side sides[3];       // from corner k to corner k + 1
    float weight[3];     // of the distance to side k, in the depth of a point
    float depth[3];      // of the corner opposite to side k
    int32_t row0, row1;  // of the tile, that it may reach
  };

 private:
  // The triangles of a pixel that count, where not all do: up to this depth, and at it up to this
  // one of the tile.
  struct Limits {
    bool is_on = false;
    std::array<float, 64> depth;
    std::array<int32_t, 64> index;
  };

  SoftTile TileOf(int64_t t) const;
  void RenderTile(int64_t t);
  void LimitTile(int64_t t, const SoftTile& tile, const float* counts, float* background);

  SoftSilhouetteOptions options_;
  int width_ = 0, height_ = 0;
  double half_side_ = 0;
  TriangleTiles tiles_;
  std::vector<TileTriangle> entries_;            // per entry of the tiles
  std::vector<float> background_;                // 1 - A, tile by tile
  std::vector<Limits> limits_;                   // per tile
  std::vector<std::array<float, 6>> gradients_;  // per entry of the tiles: of corners a, b, c
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_SOFT_SILHOUETTE_H_
