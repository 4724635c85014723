// Rows of vertex masks, for refinement and limit alike.
#ifndef CAGEFIT_CORE_SUBDIV_VERTEX_ROWS_H_
#define CAGEFIT_CORE_SUBDIV_VERTEX_ROWS_H_

#include <cstdint>

#include "absl/types/span.h"
#include "core/mesh/topology.h"
#include "core/subdiv/loop_masks.h"
#include "core/subdiv/sharp_features.h"
#include "core/subdiv/stencil_builder.h"

namespace cagefit {

// Weights of a vertex mask by rule; the smooth one by valence.
struct VertexMask {
  double curve_vertex, curve_neighbor;
  double (*ring)(int valence);
};
inline constexpr VertexMask kRefinementMask = {kCurveVertexWeight, kCurveNeighborWeight, &LoopBeta};
inline constexpr VertexMask kLimitMask = {kCurveLimitVertexWeight, kCurveLimitNeighborWeight,
                                          &LoopLimitWeight};

// Entries of a vertex row.
inline int32_t VertexRowSize(const Topology& topology, const SharpFeatures& sharp, int32_t v) {
  switch (sharp.vertex_rule[v]) {
    case VertexRule::kCorner:
      return 1;
    case VertexRule::kCrease:
      return 3;
    case VertexRule::kSmooth:
      break;
  }
  return 1 + topology.Valence(v);
}

// `neighbors`, parallel to the ring of v, are the columns that stand for its neighbours.
inline void AddVertexRow(const Topology& topology, const SharpFeatures& sharp,
                         const VertexMask& mask, int32_t v, absl::Span<const int32_t> neighbors,
                         StencilRow* row) {
  const absl::Span<const int32_t> edges = topology.RingEdges(v);
  switch (sharp.vertex_rule[v]) {
    case VertexRule::kCorner:
      row->Add(v, 1);
      break;
    case VertexRule::kCrease:
      row->Add(v, mask.curve_vertex);
      for (size_t k = 0; k < edges.size(); ++k) {
        if (sharp.sharp_edge[edges[k]]) row->Add(neighbors[k], mask.curve_neighbor);
      }
      break;
    case VertexRule::kSmooth: {
      const int valence = static_cast<int>(edges.size());
      const double weight = mask.ring(valence);
      row->Add(v, 1 - valence * weight);
      for (const int32_t neighbor : neighbors) row->Add(neighbor, weight);
      break;
    }
  }
}

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_VERTEX_ROWS_H_
