#include "core/image/mesh_edges.h"

#include <algorithm>
#include <tuple>

namespace cagefit {

MeshEdges::MeshEdges(const Triangles& triangles) {
  struct HalfEdge {
    int32_t a, b, index;  // a < b
    bool operator<(const HalfEdge& o) const {
      return std::tie(a, b, index) < std::tie(o.a, o.b, o.index);
    }
  };
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * triangles.cols());
  for (int64_t h = 0; h < 3 * triangles.cols(); ++h) {
    const int32_t a = triangles.data()[h];
    const int32_t b = triangles.data()[h % 3 == 2 ? h - 2 : h + 1];
    if (a != b) half_edges.push_back({std::min(a, b), std::max(a, b), static_cast<int32_t>(h)});
  }
  std::sort(half_edges.begin(), half_edges.end());
  // Groups of equal ends begin with their first appearance, by which edges are numbered.
  std::vector<int64_t> groups;
  for (size_t k = 0; k < half_edges.size(); ++k) {
    const bool is_first =
        k == 0 || half_edges[k].a != half_edges[k - 1].a || half_edges[k].b != half_edges[k - 1].b;
    if (is_first) groups.push_back(static_cast<int64_t>(k));
  }
  std::sort(groups.begin(), groups.end(),
            [&](int64_t a, int64_t b) { return half_edges[a].index < half_edges[b].index; });
  of_triangle_.assign(3 * triangles.cols(), -1);
  begin_.push_back(0);
  for (const int64_t group : groups) {
    const HalfEdge& first = half_edges[group];
    for (size_t k = group;
         k < half_edges.size() && half_edges[k].a == first.a && half_edges[k].b == first.b; ++k) {
      const int32_t h = half_edges[k].index;
      of_triangle_[h] = static_cast<int32_t>(vertices_.size());
      sides_.push_back({h / 3, static_cast<int8_t>(triangles.data()[h] == first.a ? 1 : -1)});
    }
    vertices_.push_back({first.a, first.b});
    begin_.push_back(static_cast<int32_t>(sides_.size()));
  }
}

}  // namespace cagefit
