#include "core/fit/refinement.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/base/status.h"
#include "core/mesh/tangential_relax.h"
#include "core/mesh/valence_flips.h"
#include "core/subdiv/edge_split.h"

namespace cagefit {

namespace {

// Of a triangle's longest edge: splitting this one and its equals spends a third to a half fewer
// vertices for the same distance than splitting all three.
constexpr double kLongShare = 0.95;

double EdgeLength(const ControlMesh& mesh, int32_t edge) {
  const auto& [a, b] = mesh.topology().edge(edge);
  return (mesh.vertices().col(a) - mesh.vertices().col(b)).norm();
}

}  // namespace

std::vector<int32_t> EdgesToSplit(const ControlMesh& fit, const TargetDistances& distances,
                                  const RefinementLimits& limits) {
  const Topology& topology = fit.topology();
  std::vector<int32_t> points(topology.triangle_count(), 0);
  for (size_t k = 0; k < distances.distance.size(); ++k) {
    const double d = distances.distance[k];
    points[distances.triangle[k]] += d > limits.tolerance && d <= limits.ignore_beyond;
  }
  std::vector<int32_t> order(topology.triangle_count());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int32_t f, int32_t g) { return points[f] > points[g]; });

  std::vector<char> taken(topology.edge_count(), 0);
  std::vector<int32_t> edges;
  for (const int32_t f : order) {
    if (points[f] == 0) break;
    double length[3], longest = 0;
    for (int c = 0; c < 3; ++c) {
      length[c] = EdgeLength(fit, topology.triangle_edge(f, c));
      longest = std::max(longest, length[c]);
    }
    for (int c = 0; c < 3; ++c) {
      const int32_t e = topology.triangle_edge(f, c);
      const bool split = length[c] >= kLongShare * longest && length[c] > limits.least_length;
      if (taken[e] || !split || static_cast<int32_t>(edges.size()) >= limits.vertices) continue;
      taken[e] = 1;
      edges.push_back(e);
    }
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

absl::StatusOr<ControlMesh> SplitAndRelax(const ControlMesh& mesh,
                                          absl::Span<const int32_t> edges) {
  ASSIGN_OR_RETURN(ControlMesh split, SplitEdges(mesh, edges));
  split = RelaxTangentially(split, /*steps=*/1);
  Triangles triangles = split.triangles();
  FlipTowardsRegularValence(split.vertices(), split.tags(), std::vector<char>(triangles.cols(), 1),
                            &triangles);
  ASSIGN_OR_RETURN(split,
                   ControlMesh::Create(split.vertices(), std::move(triangles), split.tags()));
  return RelaxTangentially(split, /*steps=*/1);
}

}  // namespace cagefit
