#include "core/subdiv/sharp_features.h"

namespace cagefit {

SharpFeatures FindSharpFeatures(const Topology& topology, const CreaseTags& tags) {
  SharpFeatures sharp;
  sharp.sharp_edge.resize(topology.edge_count());
  for (int32_t e = 0; e < topology.edge_count(); ++e) {
    sharp.sharp_edge[e] = topology.IsBoundaryEdge(e);
  }
  for (const auto& [a, b] : tags.edges) sharp.sharp_edge[topology.FindEdge(a, b)] = 1;
  std::vector<int32_t> sharp_edges(topology.vertex_count(), 0);
  for (int32_t e = 0; e < topology.edge_count(); ++e) {
    if (!sharp.sharp_edge[e]) continue;
    for (const int32_t v : topology.edge(e)) ++sharp_edges[v];
  }
  sharp.vertex_rule.resize(topology.vertex_count());
  for (int32_t v = 0; v < topology.vertex_count(); ++v) {
    sharp.vertex_rule[v] = sharp_edges[v] < 2    ? VertexRule::kSmooth
                           : sharp_edges[v] == 2 ? VertexRule::kCrease
                                                 : VertexRule::kCorner;
  }
  for (const int32_t v : tags.corners) sharp.vertex_rule[v] = VertexRule::kCorner;
  return sharp;
}

}  // namespace cagefit
