#include "core/template/edge_split.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/mesh/topology.h"

namespace cagefit {

namespace {

// Of a pass's longest edge: shorter ones wait for the next pass, as the halves of this one's may be
// longer.
constexpr double kLeastShare = 0.8;

// Splits up to `count` edges of which no two are sides of one triangle. Returns how many.
int64_t SplitOnce(const FineSurface& surface, int64_t count, TaggedMesh* tagged) {
  Points3d& V = tagged->mesh.vertices;
  Triangles& T = tagged->mesh.triangles;
  const auto topology = Topology::Create(static_cast<int32_t>(V.cols()), T);
  if (!topology.ok()) return 0;
  std::vector<std::pair<double, int32_t>> edges(topology->edge_count());
  for (int32_t e = 0; e < topology->edge_count(); ++e) {
    const auto& [a, b] = topology->edge(e);
    edges[e] = {-(V.col(a) - V.col(b)).norm(), e};
  }
  std::sort(edges.begin(), edges.end());
  std::vector<int32_t> middle(topology->edge_count(), -1);
  std::vector<char> crease(topology->edge_count(), 0), touched(topology->triangle_count(), 0);
  for (const auto& [a, b] : tagged->tags.edges) crease[topology->FindEdge(a, b)] = 1;
  int32_t vertices = topology->vertex_count();
  int64_t triangles = topology->triangle_count(), splits = 0;
  V.conservativeResize(3, vertices + count);
  T.conservativeResize(3, triangles + 2 * count);
  for (const auto& [minus_length, e] : edges) {
    if (splits == count || -minus_length < kLeastShare * -edges[0].first) break;
    const auto& [f, g] = topology->edge_triangles(e);
    if (touched[f] || (g != Topology::kNone && touched[g])) continue;
    const auto& [a, b] = topology->edge(e);
    const bool curve = crease[e] || g == Topology::kNone;
    const Eigen::Vector3d along = V.col(b) - V.col(a), half = V.col(a) + 0.5 * along;
    V.col(vertices) = (curve ? surface.NearestOnCurve(half, along, 0.5 * along.norm())
                             : surface.Nearest(half, 0.5 * along.norm()))
                          .value_or(half);
    for (const int32_t t : {f, g}) {
      if (t == Topology::kNone) continue;
      touched[t] = 1;
      T.col(triangles) = T.col(t);
      std::replace(T.col(t).begin(), T.col(t).end(), a, vertices);
      std::replace(T.col(triangles).begin(), T.col(triangles).end(), b, vertices);
      ++triangles;
    }
    middle[e] = vertices++;
    ++splits;
  }
  V.conservativeResize(3, vertices);
  T.conservativeResize(3, triangles);
  std::vector<std::array<int32_t, 2>> creases;
  for (const auto& [a, b] : tagged->tags.edges) {
    const int32_t m = middle[topology->FindEdge(a, b)];
    if (m < 0) {
      creases.push_back({a, b});
    } else {
      creases.push_back({a, m});
      creases.push_back({m, b});
    }
  }
  tagged->tags.edges = std::move(creases);
  return splits;
}

}  // namespace

void SplitLongEdges(const FineSurface& surface, int64_t vertices, TaggedMesh* tagged) {
  while (tagged->mesh.vertices.cols() < vertices) {
    if (SplitOnce(surface, vertices - tagged->mesh.vertices.cols(), tagged) == 0) return;
  }
}

}  // namespace cagefit
