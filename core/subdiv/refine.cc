#include "core/subdiv/refine.h"

#include <utility>

#include "core/subdiv/stencil_builder.h"
#include "core/subdiv/vertex_rows.h"

namespace cagefit {

namespace {

void AddEdgeRow(const Topology& topology, const SharpFeatures& sharp, int32_t e, StencilRow* row) {
  const auto& [a, b] = topology.edge(e);
  if (sharp.sharp_edge[e]) {
    row->Add(a, 0.5);
    row->Add(b, 0.5);
    return;
  }
  row->Add(a, kEdgeEndWeight);
  row->Add(b, kEdgeEndWeight);
  for (const int32_t f : topology.edge_triangles(e)) {
    for (int c = 0; c < 3; ++c) {
      const int32_t v = topology.triangles()(c, f);
      if (v != a && v != b) row->Add(v, kEdgeOppositeWeight);
    }
  }
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

StencilMatrix RefinementStencils(const Topology& topology, const SharpFeatures& sharp) {
  const int32_t n = topology.vertex_count();
  return BuildStencils(
      n + topology.edge_count(), n,
      [&](int64_t i) {
        const auto v = static_cast<int32_t>(i);
        return v < n ? VertexRowSize(topology, sharp, v) : sharp.sharp_edge[v - n] ? 2 : 4;
      },
      [&](int64_t i, StencilRow* row) {
        const auto v = static_cast<int32_t>(i);
        if (v < n) {
          AddVertexRow(topology, sharp, kRefinementMask, v, topology.Ring(v), row);
        } else {
          AddEdgeRow(topology, sharp, v - n, row);
        }
      });
}

Refinement RefineOnce(const Topology& topology, const CreaseTags& tags) {
  StencilMatrix matrix = RefinementStencils(topology, FindSharpFeatures(topology, tags));
  // Splitting a manifold mesh gives a manifold mesh.
  absl::StatusOr<Topology> fine =
      Topology::Create(static_cast<int32_t>(matrix.rows()), SplitTriangles(topology));
  return {*std::move(fine), SplitTags(topology, tags), std::move(matrix)};
}

}  // namespace cagefit
