#include "core/subdiv/limit.h"

#include <numeric>
#include <utility>
#include <vector>

#include "core/subdiv/refine.h"
#include "core/subdiv/vertex_rows.h"

namespace cagefit {

namespace {

// Position in the ring of a smooth vertex of its only sharp edge, or -1: the vertex is no dart.
int DartEdge(const Topology& topology, const SharpFeatures& sharp, int32_t v) {
  if (sharp.vertex_rule[v] != VertexRule::kSmooth) return -1;
  const absl::Span<const int32_t> edges = topology.RingEdges(v);
  for (size_t k = 0; k < edges.size(); ++k) {
    if (sharp.sharp_edge[edges[k]]) return static_cast<int>(k);
  }
  return -1;
}

// `neighbors` as in AddVertexRow.
void AddLimitRow(const Topology& topology, const SharpFeatures& sharp, int32_t v,
                 absl::Span<const int32_t> neighbors, StencilRow* row) {
  const int dart_edge = DartEdge(topology, sharp, v);
  if (dart_edge < 0) {
    AddVertexRow(topology, sharp, kLimitMask, v, neighbors, row);
    return;
  }
  const size_t valence = neighbors.size();
  const std::vector<double> weights = LoopDartLimitWeights(static_cast<int>(valence));
  row->Add(v, 1 - std::accumulate(weights.begin(), weights.end(), 0.0));
  for (size_t k = 0; k < valence; ++k) row->Add(neighbors[(dart_edge + k) % valence], weights[k]);
}

//         c            The vertex m that refinement puts on edge e = {a, b} has valence 6 inside;
//        / \           its ring is a, b and the vertices on the four other edges of the triangles
//       o - o          at e.
//      / \ / \         .
//     a - m - b
//      \ / \ /
//       o - o
//        \ /
//         d
void AddEdgeLimitRow(const Topology& topology, const SharpFeatures& sharp, int32_t e,
                     StencilRow* row) {
  const int32_t n = topology.vertex_count();
  if (sharp.sharp_edge[e]) {
    row->Add(n + e, kCurveLimitVertexWeight);
    for (const int32_t v : topology.edge(e)) row->Add(v, kCurveLimitNeighborWeight);
    return;
  }
  const double weight = LoopLimitWeight(6);
  row->Add(n + e, 1 - 6 * weight);
  for (const int32_t v : topology.edge(e)) row->Add(v, weight);
  for (const int32_t f : topology.edge_triangles(e)) {
    for (int c = 0; c < 3; ++c) {
      const int32_t other = topology.triangle_edge(f, c);
      if (other != e) row->Add(n + other, weight);
    }
  }
}

// Limit positions of the vertices of the once refined mesh in terms of these vertices. Taken from
// the coarser topology, because building the finer one costs more than all the rest.
StencilMatrix RefinedLimitStencils(const Topology& topology, const SharpFeatures& sharp) {
  const int32_t n = topology.vertex_count(), fine = n + topology.edge_count();
  return BuildStencils(
      fine, fine,
      [&](int64_t i) {
        const auto v = static_cast<int32_t>(i);
        return v < n ? VertexRowSize(topology, sharp, v) : sharp.sharp_edge[v - n] ? 3 : 7;
      },
      [&](int64_t i, StencilRow* row) {
        const auto v = static_cast<int32_t>(i);
        if (v >= n) return AddEdgeLimitRow(topology, sharp, v - n, row);
        std::vector<int32_t> neighbors(topology.RingEdges(v).begin(), topology.RingEdges(v).end());
        for (int32_t& neighbor : neighbors) neighbor += n;
        AddLimitRow(topology, sharp, v, neighbors, row);
      });
}

}  // namespace

StencilMatrix LimitPositionStencils(const Topology& topology, const CreaseTags& tags) {
  const SharpFeatures sharp = FindSharpFeatures(topology, tags);
  const int32_t n = topology.vertex_count();
  return BuildStencils(
      n, n, [&](int64_t i) { return VertexRowSize(topology, sharp, static_cast<int32_t>(i)); },
      [&](int64_t i, StencilRow* row) {
        const auto v = static_cast<int32_t>(i);
        AddLimitRow(topology, sharp, v, topology.Ring(v), row);
      });
}

LimitMesh BuildLimitMesh(const Topology& topology, const CreaseTags& tags, int levels) {
  if (levels == 0) return {LimitPositionStencils(topology, tags), topology.triangles()};
  const SharpFeatures sharp = FindSharpFeatures(topology, tags);
  if (levels == 1) {
    return {
        ComposeStencils(RefinedLimitStencils(topology, sharp), RefinementStencils(topology, sharp)),
        SplitTriangles(topology)};
  }
  Refinement fine = RefineOnce(topology, tags);
  StencilMatrix to_level = std::move(fine.matrix);
  for (int level = 2; level < levels; ++level) {
    Refinement finer = RefineOnce(fine.topology, fine.tags);
    to_level = ComposeStencils(finer.matrix, to_level);
    fine = std::move(finer);
  }
  const SharpFeatures sharp_fine = FindSharpFeatures(fine.topology, fine.tags);
  to_level = ComposeStencils(RefinementStencils(fine.topology, sharp_fine), to_level);
  return {ComposeStencils(RefinedLimitStencils(fine.topology, sharp_fine), to_level),
          SplitTriangles(fine.topology)};
}

}  // namespace cagefit
