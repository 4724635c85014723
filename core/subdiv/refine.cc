#include "core/subdiv/refine.h"

#include <algorithm>
#include <utility>

#include "core/subdiv/loop_masks.h"

namespace cagefit {

namespace {

// Rows of a stencil matrix, appended in order.
class RowBuilder {
 public:
  RowBuilder(int64_t rows, int64_t columns, int64_t entries) : columns_(columns) {
    entries_.reserve(entries);
    begin_.reserve(rows + 1);
    begin_.push_back(0);
  }
  void Add(int32_t column, double weight) { entries_.push_back({column, weight}); }
  void EndRow() {
    std::sort(entries_.begin() + begin_.back(), entries_.end());
    begin_.push_back(static_cast<int32_t>(entries_.size()));
  }
  StencilMatrix Build() const {
    StencilMatrix matrix(static_cast<int64_t>(begin_.size()) - 1, columns_);
    matrix.resizeNonZeros(static_cast<int64_t>(entries_.size()));
    std::copy(begin_.begin(), begin_.end(), matrix.outerIndexPtr());
    for (size_t k = 0; k < entries_.size(); ++k) {
      matrix.innerIndexPtr()[k] = entries_[k].first;
      matrix.valuePtr()[k] = entries_[k].second;
    }
    return matrix;
  }

 private:
  int64_t columns_;
  std::vector<std::pair<int32_t, double>> entries_;
  std::vector<int32_t> begin_;
};

// The two neighbours of a crease vertex along its crease.
std::array<int32_t, 2> CurveNeighbors(const Topology& topology, const SharpFeatures& sharp,
                                      int32_t v) {
  std::array<int32_t, 2> ends = {-1, -1};
  int found = 0;
  const absl::Span<const int32_t> ring = topology.Ring(v), edges = topology.RingEdges(v);
  for (size_t k = 0; k < ring.size(); ++k) {
    if (sharp.sharp_edge[edges[k]]) ends[found++] = ring[k];
  }
  return ends;
}

void AddVertexRow(const Topology& topology, const SharpFeatures& sharp, int32_t v,
                  double curve_vertex_weight, double curve_neighbor_weight,
                  double (*ring_weight)(int valence), RowBuilder* rows) {
  switch (sharp.vertex_rule[v]) {
    case VertexRule::kCorner:
      rows->Add(v, 1);
      break;
    case VertexRule::kCrease:
      rows->Add(v, curve_vertex_weight);
      for (const int32_t end : CurveNeighbors(topology, sharp, v)) {
        rows->Add(end, curve_neighbor_weight);
      }
      break;
    case VertexRule::kSmooth: {
      const absl::Span<const int32_t> ring = topology.Ring(v);
      const int valence = static_cast<int>(ring.size());
      const double weight = ring_weight(valence);
      rows->Add(v, 1 - valence * weight);
      for (const int32_t neighbor : ring) rows->Add(neighbor, weight);
      break;
    }
  }
  rows->EndRow();
}

void AddEdgeRow(const Topology& topology, const SharpFeatures& sharp, int32_t e, RowBuilder* rows) {
  const auto& [a, b] = topology.edge(e);
  if (sharp.sharp_edge[e]) {
    rows->Add(a, 0.5);
    rows->Add(b, 0.5);
  } else {
    rows->Add(a, kEdgeEndWeight);
    rows->Add(b, kEdgeEndWeight);
    for (const int32_t f : topology.edge_triangles(e)) {
      for (int c = 0; c < 3; ++c) {
        const int32_t v = topology.triangles()(c, f);
        if (v != a && v != b) rows->Add(v, kEdgeOppositeWeight);
      }
    }
  }
  rows->EndRow();
}

//        c0
//       /  \           Triangle (c0 c1 c2) with edge vertices e0 on (c0 c1), e1 on (c1 c2), e2 on
//       (c2 c0).
//     e0 -- e2
//     / \  / \         Children: (c0 e0 e2) (c1 e1 e0) (c2 e2 e1) (e0 e1 e2).
//   c1 - e1 - c2
Triangles SplitTriangles(const Topology& topology) {
  const int32_t n = topology.vertex_count();
  Triangles fine(3, 4 * topology.triangle_count());
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    const auto corner = topology.triangles().col(f);
    const int32_t e[3] = {n + topology.triangle_edge(f, 0), n + topology.triangle_edge(f, 1),
                          n + topology.triangle_edge(f, 2)};
    fine.col(4 * f) << corner[0], e[0], e[2];
    fine.col(4 * f + 1) << corner[1], e[1], e[0];
    fine.col(4 * f + 2) << corner[2], e[2], e[1];
    fine.col(4 * f + 3) << e[0], e[1], e[2];
  }
  return fine;
}

CreaseTags SplitTags(const Topology& topology, const CreaseTags& tags) {
  CreaseTags fine;
  fine.corners = tags.corners;
  for (const auto& [a, b] : tags.edges) {
    const int32_t middle = topology.vertex_count() + topology.FindEdge(a, b);
    fine.edges.push_back({a, middle});
    fine.edges.push_back({middle, b});
  }
  return fine;
}

}  // namespace

SharpFeatures FindSharpFeatures(const Topology& topology, const CreaseTags& tags) {
  SharpFeatures sharp;
  sharp.sharp_edge.resize(topology.edge_count());
  for (int32_t e = 0; e < topology.edge_count(); ++e)
    sharp.sharp_edge[e] = topology.IsBoundaryEdge(e);
  for (const auto& [a, b] : tags.edges) sharp.sharp_edge[topology.FindEdge(a, b)] = 1;
  sharp.vertex_rule.resize(topology.vertex_count());
  for (int32_t v = 0; v < topology.vertex_count(); ++v) {
    int sharp_edges = 0;
    for (const int32_t e : topology.RingEdges(v)) sharp_edges += sharp.sharp_edge[e];
    // One sharp edge alone ends in a dart, which is smooth.
    sharp.vertex_rule[v] = sharp_edges < 2    ? VertexRule::kSmooth
                           : sharp_edges == 2 ? VertexRule::kCrease
                                              : VertexRule::kCorner;
  }
  for (const int32_t v : tags.corners) sharp.vertex_rule[v] = VertexRule::kCorner;
  return sharp;
}

Refinement RefineOnce(const Topology& topology, const CreaseTags& tags) {
  const SharpFeatures sharp = FindSharpFeatures(topology, tags);
  const int32_t n = topology.vertex_count(), e = topology.edge_count();
  RowBuilder rows(n + e, n, 7 * int64_t{n} + 4 * int64_t{e});
  for (int32_t v = 0; v < n; ++v) {
    AddVertexRow(topology, sharp, v, kCurveVertexWeight, kCurveNeighborWeight, &LoopBeta, &rows);
  }
  for (int32_t k = 0; k < e; ++k) AddEdgeRow(topology, sharp, k, &rows);
  // Splitting a manifold mesh gives a manifold mesh.
  absl::StatusOr<Topology> fine = Topology::Create(n + e, SplitTriangles(topology));
  return {*std::move(fine), SplitTags(topology, tags), rows.Build()};
}

StencilMatrix LimitPositionStencils(const Topology& topology, const CreaseTags& tags) {
  const SharpFeatures sharp = FindSharpFeatures(topology, tags);
  const int32_t n = topology.vertex_count();
  RowBuilder rows(n, n, 7 * int64_t{n});
  for (int32_t v = 0; v < n; ++v) {
    AddVertexRow(topology, sharp, v, kCurveLimitVertexWeight, kCurveLimitNeighborWeight,
                 &LoopLimitWeight, &rows);
  }
  return rows.Build();
}

LimitMesh BuildLimitMesh(const Topology& topology, const CreaseTags& tags, int levels) {
  if (levels == 0) return {LimitPositionStencils(topology, tags), topology.triangles()};
  Refinement fine = RefineOnce(topology, tags);
  StencilMatrix to_level = std::move(fine.matrix);
  for (int level = 1; level < levels; ++level) {
    Refinement finer = RefineOnce(fine.topology, fine.tags);
    to_level = StencilMatrix(finer.matrix * to_level);
    fine = std::move(finer);
  }
  LimitMesh mesh;
  mesh.position = LimitPositionStencils(fine.topology, fine.tags) * to_level;
  mesh.triangles = fine.topology.triangles();
  return mesh;
}

}  // namespace cagefit
