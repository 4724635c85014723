#include "core/template/carry_tags.h"

#include <array>
#include <set>
#include <utility>

#include "absl/strings/str_format.h"

namespace cagefit {

namespace {

using Position = std::array<double, 3>;

Position At(const Points3d& V, int32_t v) { return {V(0, v), V(1, v), V(2, v)}; }

std::pair<Position, Position> Ends(const Points3d& V, int32_t a, int32_t b) {
  const Position at_a = At(V, a), at_b = At(V, b);
  return at_a < at_b ? std::make_pair(at_a, at_b) : std::make_pair(at_b, at_a);
}

}  // namespace

absl::StatusOr<CreaseTags> CarryTags(const CreaseTags& tags, const Points3d& from,
                                     const Points3d& to, const Topology& topology) {
  const auto check = [&](int32_t v) {
    if (v >= 0 && v < from.cols()) return absl::OkStatus();
    return absl::InvalidArgumentError(
        absl::StrFormat("tags: vertex %d is outside [0, %d)", v, from.cols()));
  };
  std::set<std::pair<Position, Position>> creases;
  for (const auto& edge : tags.edges) {
    for (const int32_t v : edge) {
      if (const absl::Status status = check(v); !status.ok()) return status;
    }
    creases.insert(Ends(from, edge[0], edge[1]));
  }
  std::set<Position> corners;
  for (const int32_t v : tags.corners) {
    if (const absl::Status status = check(v); !status.ok()) return status;
    corners.insert(At(from, v));
  }
  CreaseTags carried;
  for (int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto& [a, b] = topology.edge(e);
    if (creases.count(Ends(to, a, b)) > 0) carried.edges.push_back({a, b});
  }
  for (int32_t v = 0; v < topology.vertex_count(); ++v) {
    if (corners.count(At(to, v)) > 0) carried.corners.push_back(v);
  }
  return carried;
}

}  // namespace cagefit
