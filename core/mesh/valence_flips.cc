#include "core/mesh/valence_flips.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/mesh/topology.h"

namespace cagefit {

namespace {

constexpr int kMaxPasses = 8;       // each flips what does not touch; few are needed
constexpr double kSameWay = 0.866;  // cosine of 30 degrees
constexpr double kShapeKept = 0.7;  // of the worse triangle's quality
constexpr int kLeastInside = 4, kLeastOnBoundary = 3;  // valences after a flip

// The two triangles (a, b, c) and (b, a, d) of an inner edge {a, b}.
struct Diamond {
  int32_t a, b, c, d;
};

Diamond DiamondAt(const Topology& topology, int32_t edge) {
  const int32_t f = topology.edge_triangles(edge)[0];
  int corner = 0;
  while (topology.triangle_edge(f, corner) != edge) ++corner;
  const int32_t twin = topology.opposite(3 * f + corner);
  const auto corners = topology.triangles().col(f);
  return {corners[corner], corners[(corner + 1) % 3], corners[(corner + 2) % 3],
          topology.triangles()((twin % 3 + 2) % 3, twin / 3)};
}

// Unit normal and quality (1: equilateral, 0: degenerate) of a triangle.
struct Shape {
  Shape(const Points3d& V, int32_t a, int32_t b, int32_t c) {
    const Eigen::Vector3d ab = V.col(b) - V.col(a), ac = V.col(c) - V.col(a);
    normal = ab.cross(ac);
    const double twice_area = normal.norm();
    const double squares = ab.squaredNorm() + ac.squaredNorm() + (ac - ab).squaredNorm();
    if (squares > 0) quality = 2 * std::sqrt(3.0) * twice_area / squares;
    if (twice_area > 0) normal /= twice_area;
  }
  Eigen::Vector3d normal;
  double quality = 0;
};

bool KeepsShape(const Points3d& V, const Diamond& q) {
  const Shape old1(V, q.a, q.b, q.c), old2(V, q.b, q.a, q.d);
  const Shape new1(V, q.a, q.d, q.c), new2(V, q.d, q.b, q.c);
  const Eigen::Vector3d normal = (old1.normal + old2.normal).normalized();
  for (const Shape* shape : {&old1, &old2, &new1, &new2}) {
    if (!(shape->normal.dot(normal) >= kSameWay)) return false;
  }
  return std::min(new1.quality, new2.quality) >= kShapeKept * std::min(old1.quality, old2.quality);
}

// What one pass works on. Flips of a pass share no vertex, so that the connectivity at its start
// stays true for those that follow.
class FlipPass {
 public:
  FlipPass(const Points3d& V, const CreaseTags& tags, Triangles* triangles)
      : V_(V),
        topology_(*Topology::Create(static_cast<int32_t>(V.cols()), *triangles)),
        fixed_(topology_.edge_count(), 0),
        touched_(V.cols(), 0),
        triangles_(triangles) {
    for (const auto& [a, b] : tags.edges) fixed_[topology_.FindEdge(a, b)] = 1;
  }

  // Returns whether any edge was flipped.
  bool Run(const std::vector<char>& movable) {
    bool any = false;
    for (int32_t e = 0; e < topology_.edge_count(); ++e) {
      const auto& [f, g] = topology_.edge_triangles(e);
      if (fixed_[e] || g == Topology::kNone || !(movable[f] || movable[g])) continue;
      const Diamond q = DiamondAt(topology_, e);
      if (touched_[q.a] || touched_[q.b] || touched_[q.c] || touched_[q.d]) continue;
      if (!Helps(q) || topology_.FindEdge(q.c, q.d) != Topology::kNone || !KeepsShape(V_, q)) {
        continue;
      }
      triangles_->col(f) << q.a, q.d, q.c;
      triangles_->col(g) << q.d, q.b, q.c;
      touched_[q.a] = touched_[q.b] = touched_[q.c] = touched_[q.d] = 1;
      any = true;
    }
    return any;
  }

 private:
  // Squared difference from the regular valence after a change.
  int Deviation(int32_t v, int change) const {
    const int regular = topology_.IsBoundaryVertex(v) ? 4 : 6;
    const int difference = topology_.Valence(v) + change - regular;
    return difference * difference;
  }
  bool MayLose(int32_t v) const {
    const int least = topology_.IsBoundaryVertex(v) ? kLeastOnBoundary : kLeastInside;
    return topology_.Valence(v) > least;
  }
  bool Helps(const Diamond& q) const {
    if (!MayLose(q.a) || !MayLose(q.b)) return false;
    const int before =
        Deviation(q.a, 0) + Deviation(q.b, 0) + Deviation(q.c, 0) + Deviation(q.d, 0);
    const int after =
        Deviation(q.a, -1) + Deviation(q.b, -1) + Deviation(q.c, 1) + Deviation(q.d, 1);
    return after < before;
  }

  const Points3d& V_;
  const Topology topology_;
  std::vector<char> fixed_;    // per edge
  std::vector<char> touched_;  // per vertex
  Triangles* triangles_;
};

}  // namespace

void FlipTowardsRegularValence(const Points3d& vertices, const CreaseTags& tags,
                               const std::vector<char>& movable, Triangles* triangles) {
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    if (!FlipPass(vertices, tags, triangles).Run(movable)) return;
  }
}

}  // namespace cagefit
