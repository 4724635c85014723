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
  if (absl::Status status = topology.LinkEdges(); !status.ok()) return status;
  if (absl::Status status = topology.WalkRings(); !status.ok()) return status;
  return topology;
}

absl::Status Topology::LinkEdges() {
  const int32_t half_edges = 3 * triangle_count();
  const auto from = [&](int32_t h) { return triangles_(h % 3, h / 3); };
  const auto to = [&](int32_t h) { return triangles_((h + 1) % 3, h / 3); };
  // Half-edges of the same edge become neighbours when sorted by their smaller, then their larger
  // vertex.
  std::vector<int32_t> order(half_edges);
  std::iota(order.begin(), order.end(), 0);
  const auto ends = [&](int32_t h) { return std::minmax({from(h), to(h)}); };
  std::sort(order.begin(), order.end(), [&](int32_t a, int32_t b) {
    return std::make_pair(ends(a), a) < std::make_pair(ends(b), b);
  });
  opposite_.assign(half_edges, kNone);
  for (int32_t k = 0; k < half_edges;) {
    int32_t end = k + 1;
    while (end < half_edges && ends(order[end]) == ends(order[k])) ++end;
    const int32_t a = order[k], b = order[end - 1];
    if (end - k > 2) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "edge (%d, %d): %d triangles meet there; at most two may", from(a), to(a), end - k));
    }
    if (end - k == 2) {
      if (from(a) == from(b)) {
        return absl::InvalidArgumentError(
            absl::StrFormat("edge (%d, %d): triangles %d and %d are oriented against each other",
                            from(a), to(a), a / 3, b / 3));
      }
      opposite_[a] = b;
      opposite_[b] = a;
    }
    k = end;
  }

  triangle_edges_.resize(3, triangle_count());
  for (int32_t h = 0; h < half_edges; ++h) {
    const int32_t other = opposite_[h];
    if (other != kNone && other < h) {
      const int32_t e = triangle_edges_(other % 3, other / 3);
      triangle_edges_(h % 3, h / 3) = e;
      edge_triangles_[e][1] = h / 3;
    } else {
      triangle_edges_(h % 3, h / 3) = edge_count();
      edges_.push_back({std::min(from(h), to(h)), std::max(from(h), to(h))});
      edge_triangles_.push_back({h / 3, kNone});
    }
  }
  return absl::OkStatus();
}

absl::Status Topology::WalkRings() {
  // Any outgoing half-edge of each vertex; on a boundary the one without an opposite, from which
  // the fan runs counter-clockwise.
  std::vector<int32_t> first(vertex_count_, kNone), degree(vertex_count_, 0);
  for (int32_t h = 0; h < 3 * triangle_count(); ++h) {
    const int32_t v = triangles_(h % 3, h / 3);
    ++degree[v];
    if (first[v] == kNone || opposite_[h] == kNone) first[v] = h;
  }
  boundary_vertex_.assign(vertex_count_, 0);
  ring_begin_.assign(1, 0);
  ring_begin_.reserve(vertex_count_ + 1);
  ring_.reserve(2 * edges_.size());
  for (int32_t v = 0; v < vertex_count_; ++v) {
    if (first[v] == kNone) {
      return absl::InvalidArgumentError(absl::StrFormat("vertex %d: no triangle uses it", v));
    }
    int32_t walked = 0;
    int32_t h = first[v];
    boundary_vertex_[v] = opposite_[h] == kNone;
    do {
      ring_.push_back(triangles_((h + 1) % 3, h / 3));
      edge_of_ring_.push_back(triangle_edges_(h % 3, h / 3));
      ++walked;
      const int32_t incoming = h - h % 3 + (h + 2) % 3;  // from the third corner to v
      if (opposite_[incoming] == kNone) {
        ring_.push_back(triangles_((h + 2) % 3, h / 3));
        edge_of_ring_.push_back(triangle_edges_(incoming % 3, incoming / 3));
        break;
      }
      h = opposite_[incoming];
    } while (h != first[v] && walked <= degree[v]);
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
  if (a < 0 || a >= vertex_count_) return kNone;
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
