// Silhouette image whose 0.5 contour is the true outline of the mesh, whatever its tessellation.
//
//   A(p) = sigmoid( s |s| / sigma )
//
// s the signed distance from pixel centre p to the outline (mesh_outline.h), positive inside, in
// normalised device coordinates (unit: half the smaller image side): the image of
// silhouette_image.h. Beyond SilhouetteReach A is 0 or 1.
//
// With c the outline's point nearest to p, ds/dc is the unit vector from c to p for a pixel
// outside, from p to c inside, and c moves with the edge that it lies on:
//
//   dA = dA/ds ds/dc . ((1 - t) da + t db),   dA/ds = A (1 - A) 2 |s| / sigma
//
// Where c is the crossing of two edges with normals m and m', m . dc = m . ((1 - t) da + t db), and
// likewise for m': dA is the sum of a row for each edge.
#ifndef CAGEFIT_CORE_IMAGE_OUTLINE_SILHOUETTE_H_
#define CAGEFIT_CORE_IMAGE_OUTLINE_SILHOUETTE_H_

#include <vector>

#include "core/image/image.h"
#include "core/image/mesh_outline.h"
#include "core/image/outline_distance.h"

namespace cagefit {

// Not thread-safe. Buffers keep their capacity.
class OutlineSilhouette {
 public:
  // A part of dA at one pixel: by_point . ((1 - t) da + t db), with edge (a, b), per pixel of
  // length.
  struct Row {
    int32_t pixel;  // y * width + x
    int32_t edge;
    double t;
    Eigen::Vector2d by_point;
    double share;  // number of rows of this pixel
  };

  // `tiles` as MeshOutline::Find wants them.
  void Render(const ProjectedMesh& mesh, const Triangles& triangles, const MeshEdges& edges,
              const TriangleTiles& tiles, int width, int height, double sigma, Image* silhouette);

  // Whether the mesh covers a pixel's centre.
  bool IsInside(int32_t pixel) const { return inside_[pixel] != 0; }

  // Rows of the last rendering, in order of pixels.
  const std::vector<Row>& rows() const { return rows_; }

  // Adds dE/d(x, y) of every vertex (2 x n, per pixel of length) given dE/dA.
  void AddGradient(const MeshEdges& edges, const Image& by_silhouette, Points2d* by_vertex) const;

  const MeshOutline& outline() const { return outline_; }
  const OutlineDistance& distance() const { return distance_; }

 private:
  // The outline's point nearest to a pixel that it is near to.
  struct Foot {
    Eigen::Vector2d a, along;  // its edge
    double t;
    int end;  // of the piece: -1 its begin, 1 its end, 0 between them
  };
  Foot FootOf(const ProjectedMesh& mesh, const MeshEdges& edges, int32_t pixel,
              const Eigen::Vector2d& p) const;
  void AddRows(const ProjectedMesh& mesh, const MeshEdges& edges, int32_t pixel,
               const Eigen::Vector2d& p, const Foot& foot, double value, double variance,
               std::vector<Row>* rows) const;

  MeshOutline outline_;
  OutlineDistance distance_;
  std::vector<char> inside_;
  std::vector<std::vector<Row>> found_;  // per chunk of image rows
  std::vector<Row> rows_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_OUTLINE_SILHOUETTE_H_
