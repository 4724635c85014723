#include "core/mesh/topology.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "absl/strings/str_format.h"

namespace cagefit {

namespace {

absl::Status CheckTriangles(int32_t vertex_count, const Triangles& triangles) {
  for (int64_t f = 0; f < triangles.cols(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const int32_t v = triangles(c, f);
      if (v < 0 || v >= vertex_count) {
        return absl::InvalidArgumentError(
            absl::StrFormat("triangle %d: vertex index %d is outside [0, %d)", f, v, vertex_count));
      }
      if (v == triangles((c + 1) % 3, f)) {
        return absl::InvalidArgumentError(
            absl::StrFormat("triangle %d: vertex %d appears twice", f, v));
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Topology> Topology::Create(int32_t vertex_count, Triangles triangles) {
  if (vertex_count <= 0 || triangles.cols() == 0) {
    return absl::InvalidArgumentError(
        absl::StrFormat("mesh: %d vertices and %d triangles", vertex_count, triangles.cols()));
  }
  if (absl::Status status = CheckTriangles(vertex_count, triangles); !status.ok()) return status;
  Topology topology;
  topology.vertex_count_ = vertex_count;
  topology.triangles_ = std::move(triangles);
  if (absl::Status status = topology.PairHalfEdges(); !status.ok()) return status;
  topology.NumberEdges();
  if (absl::Status status = topology.WalkRings(); !status.ok()) return status;
  return topology;
}

// Half-edges of one edge become neighbours when each vertex's bucket, of the half-edges whose
// smaller end it is, is sorted by the larger end. Buckets are as small as valences.
absl::Status Topology::PairHalfEdges() {
  const int32_t half_edges = 3 * triangle_count();
  std::vector<int32_t> begin(vertex_count_ + 1, 0);
  for (int32_t h = 0; h < half_edges; ++h) ++begin[std::min(From(h), To(h)) + 1];
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  struct Entry {
    int32_t larger_end, half_edge;
    bool operator<(const Entry& o) const {
      return larger_end != o.larger_end ? larger_end < o.larger_end : half_edge < o.half_edge;
    }
  };
  std::vector<Entry> entries(half_edges);
  std::vector<int32_t> next(begin.begin(), begin.end() - 1);
  for (int32_t h = 0; h < half_edges; ++h) {
    const int32_t a = From(h), b = To(h);
    entries[next[std::min(a, b)]++] = {std::max(a, b), h};
  }
  opposite_.assign(half_edges, kNone);
  for (int32_t v = 0; v < vertex_count_; ++v) {
    std::sort(entries.begin() + begin[v], entries.begin() + begin[v + 1]);
    for (int32_t k = begin[v]; k < begin[v + 1];) {
      int32_t end = k + 1;
      while (end < begin[v + 1] && entries[end].larger_end == entries[k].larger_end) ++end;
      const int32_t a = entries[k].half_edge, b = entries[end - 1].half_edge;
      if (end - k > 2) {
        return absl::InvalidArgumentError(absl::StrFormat(
            "edge (%d, %d): %d triangles meet there; at most two may", From(a), To(a), end - k));
      }
      if (end - k == 2) {
        if (From(a) == From(b)) {
          return absl::InvalidArgumentError(
              absl::StrFormat("edge (%d, %d): triangles %d and %d are oriented against each other",
                              From(a), To(a), a / 3, b / 3));
        }
        opposite_[a] = b;
        opposite_[b] = a;
      }
      k = end;
    }
  }
  return absl::OkStatus();
}

void Topology::NumberEdges() {
  const int32_t half_edges = 3 * triangle_count();
  int32_t count = 0;
  for (int32_t h = 0; h < half_edges; ++h) count += opposite_[h] == kNone || opposite_[h] > h;
  edges_.reserve(count);
  edge_triangles_.reserve(count);
  triangle_edges_.resize(3, triangle_count());
  int32_t* edge_of = triangle_edges_.data();
  for (int32_t h = 0; h < half_edges; ++h) {
    const int32_t other = opposite_[h];
    if (other != kNone && other < h) {
      edge_of[h] = edge_of[other];
      edge_triangles_[edge_of[h]][1] = h / 3;
    } else {
      edge_of[h] = edge_count();
      edges_.push_back({std::min(From(h), To(h)), std::max(From(h), To(h))});
      edge_triangles_.push_back({h / 3, kNone});
    }
  }
}

absl::Status Topology::WalkRings() {
  // Any outgoing half-edge of each vertex; on a boundary the one without an opposite, from which
  // the fan runs counter-clockwise.
  std::vector<int32_t> first(vertex_count_, kNone), degree(vertex_count_, 0);
  for (int32_t h = 0; h < 3 * triangle_count(); ++h) {
    const int32_t v = From(h);
    ++degree[v];
    if (first[v] == kNone || opposite_[h] == kNone) first[v] = h;
  }
  boundary_vertex_.assign(vertex_count_, 0);
  ring_begin_.assign(1, 0);
  ring_begin_.reserve(vertex_count_ + 1);
  ring_.reserve(2 * edges_.size());
  edge_of_ring_.reserve(2 * edges_.size());
  const int32_t* edge_of = triangle_edges_.data();
  for (int32_t v = 0; v < vertex_count_; ++v) {
    if (first[v] == kNone) {
      return absl::InvalidArgumentError(absl::StrFormat("vertex %d: no triangle uses it", v));
    }
    int32_t walked = 0;
    int32_t h = first[v];
    boundary_vertex_[v] = opposite_[h] == kNone;
    do {
      ring_.push_back(To(h));
      edge_of_ring_.push_back(edge_of[h]);
      ++walked;
      const int32_t incoming = h % 3 == 0 ? h + 2 : h - 1;  // from the third corner to v
      if (opposite_[incoming] == kNone) {
        ring_.push_back(From(incoming));
        edge_of_ring_.push_back(edge_of[incoming]);
        break;
      }
      h = opposite_[incoming];
    } while (h != first[v]);
    if (walked != degree[v]) {
      return absl::InvalidArgumentError(
          absl::StrFormat("vertex %d: its %d triangles do not form one fan (one reaches %d)", v,
                          degree[v], walked));
    }
    ring_begin_.push_back(static_cast<int32_t>(ring_.size()));
  }
  return absl::OkStatus();
}

int32_t Topology::FindEdge(int32_t a, int32_t b) const {
  if (std::min(a, b) < 0 || std::max(a, b) >= vertex_count_) return kNone;
  if (Valence(b) < Valence(a)) std::swap(a, b);
  const absl::Span<const int32_t> ring = Ring(a);
  const auto found = std::find(ring.begin(), ring.end(), b);
  return found == ring.end() ? kNone : RingEdges(a)[found - ring.begin()];
}

std::vector<std::vector<int32_t>> Topology::BoundaryLoops() const {
  std::vector<int32_t> next(vertex_count_, kNone);
  for (int32_t h = 0; h < 3 * triangle_count(); ++h) {
    if (opposite_[h] == kNone) next[triangles_(h % 3, h / 3)] = triangles_((h + 1) % 3, h / 3);
  }
  std::vector<std::vector<int32_t>> loops;
  for (int32_t v = 0; v < vertex_count_; ++v) {
    if (next[v] == kNone) continue;
    loops.emplace_back();
    for (int32_t at = v; next[at] != kNone;) {
      loops.back().push_back(at);
      at = std::exchange(next[at], kNone);
    }
  }
  return loops;
}

int32_t Topology::Components(std::vector<int32_t>* component_of_vertex) const {
  component_of_vertex->assign(vertex_count_, kNone);
  std::vector<int32_t> stack;
  int32_t components = 0;
  for (int32_t v = 0; v < vertex_count_; ++v) {
    if ((*component_of_vertex)[v] != kNone) continue;
    (*component_of_vertex)[v] = components;
    stack.push_back(v);
    while (!stack.empty()) {
      const int32_t at = stack.back();
      stack.pop_back();
      for (const int32_t neighbor : Ring(at)) {
        if ((*component_of_vertex)[neighbor] != kNone) continue;
        (*component_of_vertex)[neighbor] = components;
        stack.push_back(neighbor);
      }
    }
    ++components;
  }
  return components;
}

}  // namespace cagefit
