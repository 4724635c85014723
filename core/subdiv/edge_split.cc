#include "core/subdiv/edge_split.h"

#include <utility>
#include <vector>

#include "core/mesh/valence_flips.h"
#include "core/subdiv/refine.h"

namespace cagefit {

namespace {

constexpr int32_t kWhole = -1;

// New vertex of every edge, or kWhole.
std::vector<int32_t> NumberMiddles(const Topology& topology, absl::Span<const int32_t> edges,
                                   int32_t* vertices) {
  std::vector<int32_t> middle(topology.edge_count(), kWhole);
  for (const int32_t e : edges) middle[e] = 0;
  *vertices = topology.vertex_count();
  for (int32_t& m : middle) {
    if (m != kWhole) m = (*vertices)++;
  }
  return middle;
}

// The share of the edges at v, on a curve of those along it, that are split.
double SplitShare(const Topology& topology, const SharpFeatures& sharp,
                  const std::vector<int32_t>& middle, int32_t v) {
  const bool curve = sharp.vertex_rule[v] == VertexRule::kCrease;
  int split = 0, all = 0;
  for (const int32_t e : topology.RingEdges(v)) {
    if (curve && !sharp.sharp_edge[e]) continue;
    ++all;
    split += middle[e] != kWhole;
  }
  return all > 0 ? static_cast<double>(split) / all : 0;
}

Points3d PlaceVertices(const ControlMesh& mesh, const std::vector<int32_t>& middle,
                       int32_t vertices) {
  const Topology& topology = mesh.topology();
  const SharpFeatures sharp = FindSharpFeatures(topology, mesh.tags());
  Points3d refined;
  ApplyStencils(RefinementStencils(topology, sharp), mesh.vertices(), &refined);
  const int32_t n = topology.vertex_count();
  Points3d placed(3, vertices);
  for (int32_t v = 0; v < n; ++v) {
    const auto x = mesh.vertices().col(v);
    placed.col(v) = x + SplitShare(topology, sharp, middle, v) * (refined.col(v) - x);
  }
  for (int32_t e = 0; e < topology.edge_count(); ++e) {
    if (middle[e] != kWhole) placed.col(middle[e]) = refined.col(n + e);
  }
  return placed;
}

// The pieces of a triangle with corners v and middles m (of its half-edges, or kWhole).
void AddPieces(const Points3d& V, const int32_t (&v)[3], const int32_t (&m)[3],
               std::vector<int32_t>* pieces) {
  const auto add = [pieces](int32_t a, int32_t b, int32_t c) {
    pieces->insert(pieces->end(), {a, b, c});
  };
  const int splits = (m[0] != kWhole) + (m[1] != kWhole) + (m[2] != kWhole);
  if (splits == 0) return add(v[0], v[1], v[2]);
  if (splits == 3) {
    for (int c = 0; c < 3; ++c) add(v[c], m[c], m[(c + 2) % 3]);
    return add(m[0], m[1], m[2]);
  }
  // Turned so that half-edge k is split and, of two, k + 1 as well.
  int k = 0;
  while (m[k] == kWhole || (splits == 2 && m[(k + 1) % 3] == kWhole)) ++k;
  const int32_t a = v[k], b = v[(k + 1) % 3], c = v[(k + 2) % 3], x = m[k];
  if (splits == 1) {
    add(a, x, c);
    return add(x, b, c);
  }
  const int32_t y = m[(k + 1) % 3];
  add(x, b, y);
  if ((V.col(a) - V.col(y)).squaredNorm() < (V.col(x) - V.col(c)).squaredNorm()) {
    add(a, x, y);
    return add(a, y, c);
  }
  add(a, x, c);
  add(x, y, c);
}

CreaseTags SplitTags(const ControlMesh& mesh, const std::vector<int32_t>& middle) {
  CreaseTags tags;
  tags.corners = mesh.tags().corners;
  for (const auto& [a, b] : mesh.tags().edges) {
    const int32_t m = middle[mesh.topology().FindEdge(a, b)];
    if (m == kWhole) {
      tags.edges.push_back({a, b});
    } else {
      tags.edges.push_back({a, m});
      tags.edges.push_back({m, b});
    }
  }
  return tags;
}

}  // namespace

absl::StatusOr<ControlMesh> SplitEdges(const ControlMesh& mesh, absl::Span<const int32_t> edges) {
  const Topology& topology = mesh.topology();
  int32_t vertices = 0;
  const std::vector<int32_t> middle = NumberMiddles(topology, edges, &vertices);
  Points3d V = PlaceVertices(mesh, middle, vertices);

  std::vector<int32_t> pieces;
  std::vector<char> movable;  // pieces of split triangles
  for (int32_t f = 0; f < topology.triangle_count(); ++f) {
    int32_t v[3], m[3];
    for (int c = 0; c < 3; ++c) {
      v[c] = topology.triangles()(c, f);
      m[c] = middle[topology.triangle_edge(f, c)];
    }
    AddPieces(V, v, m, &pieces);
    const bool whole = m[0] == kWhole && m[1] == kWhole && m[2] == kWhole;
    movable.resize(pieces.size() / 3, whole ? 0 : 1);
  }
  Triangles triangles =
      Eigen::Map<const Triangles>(pieces.data(), 3, static_cast<int64_t>(pieces.size()) / 3);
  CreaseTags tags = SplitTags(mesh, middle);
  FlipTowardsRegularValence(V, tags, movable, &triangles);
  return ControlMesh::Create(std::move(V), std::move(triangles), std::move(tags));
}

}  // namespace cagefit
