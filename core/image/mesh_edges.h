// The edges of any triangle mesh, manifold or not, with the triangles at them.
#ifndef CAGEFIT_CORE_IMAGE_MESH_EDGES_H_
#define CAGEFIT_CORE_IMAGE_MESH_EDGES_H_

#include <array>
#include <cstdint>
#include <vector>

#include "absl/types/span.h"
#include "core/base/types.h"

namespace cagefit {

// Immutable, thread-safe. Edges are numbered in order of first appearance, corner by corner, as in
// Topology.
class MeshEdges {
 public:
  // A triangle's edge, seen from the triangle.
  struct Side {
    int32_t triangle;
    int8_t direction;  // +1 where the triangle runs along the edge from its first vertex, or -1
  };

  explicit MeshEdges(const Triangles& triangles);

  int64_t size() const { return static_cast<int64_t>(vertices_.size()); }
  const std::array<int32_t, 2>& vertices(int64_t e) const { return vertices_[e]; }
  absl::Span<const Side> sides(int64_t e) const {
    return absl::MakeConstSpan(sides_).subspan(begin_[e], begin_[e + 1] - begin_[e]);
  }
  // Edge from corner c to corner (c + 1) % 3 of triangle f; -1 where both are one vertex.
  int32_t of_triangle(int64_t f, int c) const { return of_triangle_[3 * f + c]; }

 private:
  std::vector<std::array<int32_t, 2>> vertices_;
  std::vector<int32_t> begin_, of_triangle_;
  std::vector<Side> sides_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_MESH_EDGES_H_
