// The true outline of a projected mesh: the boundary of the union of its triangles.
//
// An edge may lie on it where all its triangles are on one side of it: a fold or a border. Such
// edges are cut where they cross each other, and of the pieces those are kept whose other side no
// triangle covers. Hence the outline is exact whatever the tessellation, occluded folds are no part
// of it, and every point of it moves with two vertices, or, where two edges cross, with four:
//
//   c = (1 - t) a + t b                     on edge (a, b)
//   c = a + t (b - a) = d + u (e - d)       at the crossing of (a, b) and (d, e)
#ifndef CAGEFIT_CORE_IMAGE_MESH_OUTLINE_H_
#define CAGEFIT_CORE_IMAGE_MESH_OUTLINE_H_

#include <cstdint>
#include <vector>

#include "core/image/mesh_edges.h"
#include "core/image/outline.h"
#include "core/image/triangle_tiles.h"

namespace cagefit {

// Where segments (a, b) and (d, e) cross: a + t (b - a) = d + u (e - d), 0 < t, u < 1. False where
// they do not, or are parallel.
bool CrossSegments(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& d,
                   const Eigen::Vector2d& e, double* t, double* u);

// Not thread-safe. Buffers keep their capacity.
class MeshOutline {
 public:
  // A segment of the outline: part of an edge of the mesh. Its ends are vertices, or the crossing
  // with another edge.
  struct Piece {
    int32_t edge;
    double t0, t1;                           // along the edge, from its first vertex
    int32_t crossing0 = -1, crossing1 = -1;  // the other edges at the ends; -1: a vertex
  };

  // `tiles` were built from the same mesh, with a pad of at least `reach`, and without margin. Only
  // what is within `reach` pixels of the image is found.
  void Find(const ProjectedMesh& mesh, const Triangles& triangles, const MeshEdges& edges,
            const TriangleTiles& tiles, int width, int height, double reach);

  // Segment k is piece k.
  const Outline& outline() const { return outline_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  // +1 where the shape is on the left of the piece's edge, seen from its first vertex with x to the
  // right and y upwards, or -1.
  int side(const Piece& piece) const { return side_[piece.edge]; }

 private:
  struct Cut {
    double t;
    int32_t edge;  // that crosses here
  };

  void FindFolds(const ProjectedMesh& mesh, const Triangles& triangles, const MeshEdges& edges);
  void BinFolds(const ProjectedMesh& mesh, const MeshEdges& edges);
  template <typename Body>
  void ForBins(const ProjectedMesh& mesh, const MeshEdges& edges, int32_t edge,
               const Body& body) const;
  // Where other folds cross the edge, in order.
  void CutFold(const ProjectedMesh& mesh, const MeshEdges& edges, int32_t edge,
               std::vector<Cut>* cuts) const;
  // Appends the pieces between cuts whose outer side is not covered, joined where nothing changes.
  void KeepOuter(const ProjectedMesh& mesh, const Triangles& triangles, const MeshEdges& edges,
                 const TriangleTiles& tiles, int32_t edge, const std::vector<Cut>& cuts,
                 std::vector<Piece>* pieces) const;

  Eigen::Vector2d low_, high_;  // what is looked at, pixels
  std::vector<int8_t>
      turn_;  // per triangle: the sign of its area in the image; 0: none, or not seen
  std::vector<int8_t> side_;    // per edge: 0, or on which side its triangles are
  std::vector<int32_t> folds_;  // edges that may be outline
  double bin_side_ = 1;
  int bin_columns_ = 0, bin_rows_ = 0;
  std::vector<int32_t> bin_begin_, bin_folds_;
  std::vector<std::vector<Piece>> found_;  // per chunk of folds
  std::vector<Piece> pieces_;
  Outline outline_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_MESH_OUTLINE_H_
