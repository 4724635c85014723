// Connectivity of a manifold triangle mesh: edges, boundaries, one-rings. Immutable after Create;
// thread-safe.
//
// Half-edge h = 3 f + c runs from corner c to corner (c + 1) % 3 of triangle f.
#ifndef CAGEFIT_CORE_MESH_TOPOLOGY_H_
#define CAGEFIT_CORE_MESH_TOPOLOGY_H_

#include <array>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/base/types.h"

namespace cagefit {

class Topology {
 public:
  static constexpr int32_t kNone = -1;

  // Checks indices in [0, vertex_count), no triangle with a repeated vertex, every edge in at most
  // two triangles of opposite orientation, every vertex in exactly one fan of triangles.
  // INVALID_ARGUMENT names the first offending vertex, edge or triangle.
  static absl::StatusOr<Topology> Create(int32_t vertex_count, Triangles triangles);

  int32_t vertex_count() const { return vertex_count_; }
  int32_t triangle_count() const { return static_cast<int32_t>(triangles_.cols()); }
  int32_t edge_count() const { return static_cast<int32_t>(edges_.size()); }
  const Triangles& triangles() const { return triangles_; }

  // Vertices {a, b} of edge e, a < b. Edges are numbered in order of first appearance.
  const std::array<int32_t, 2>& edge(int32_t e) const { return edges_[e]; }
  // Triangles at edge e; the second is kNone on a boundary.
  const std::array<int32_t, 2>& edge_triangles(int32_t e) const { return edge_triangles_[e]; }
  // Edge of half-edge 3 f + c.
  int32_t triangle_edge(int32_t f, int c) const { return triangle_edges_(c, f); }
  // The half-edge on the other side, or kNone.
  int32_t opposite(int32_t half_edge) const { return opposite_[half_edge]; }
  // Edge {a, b} in either order, or kNone.
  int32_t FindEdge(int32_t a, int32_t b) const;

  bool IsBoundaryEdge(int32_t e) const { return edge_triangles_[e][1] == kNone; }
  bool IsBoundaryVertex(int32_t v) const { return boundary_vertex_[v]; }

  // One-ring of v, counter-clockwise. On a boundary it runs from one boundary neighbour to the
  // other.
  absl::Span<const int32_t> Ring(int32_t v) const {
    return absl::MakeConstSpan(ring_).subspan(ring_begin_[v], ring_begin_[v + 1] - ring_begin_[v]);
  }
  // Edges from v to its ring neighbours, in the same order.
  absl::Span<const int32_t> RingEdges(int32_t v) const {
    return absl::MakeConstSpan(edge_of_ring_)
        .subspan(ring_begin_[v], ring_begin_[v + 1] - ring_begin_[v]);
  }
  // Number of neighbours.
  int32_t Valence(int32_t v) const { return ring_begin_[v + 1] - ring_begin_[v]; }

  // Boundary loops, each a closed list of vertices, in the direction of the boundary half-edges'
  // triangles.
  std::vector<std::vector<int32_t>> BoundaryLoops() const;
  // Connected components: component index of every vertex, and their number.
  int32_t Components(std::vector<int32_t>* component_of_vertex) const;

 private:
  Topology() = default;
  absl::Status LinkEdges();
  absl::Status WalkRings();

  int32_t vertex_count_ = 0;
  Triangles triangles_;
  Triangles triangle_edges_;                            // 3 x F
  std::vector<int32_t> opposite_;                       // 3 F
  std::vector<std::array<int32_t, 2>> edges_;           // E
  std::vector<std::array<int32_t, 2>> edge_triangles_;  // E
  std::vector<char> boundary_vertex_;                   // n
  std::vector<int32_t> ring_begin_, ring_;
  std::vector<int32_t> edge_of_ring_;  // edge from the vertex to that ring neighbour
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_MESH_TOPOLOGY_H_
