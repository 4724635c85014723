#include "core/template/needle_removal.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>
#include <vector>

#include "core/mesh/topology.h"
#include "core/mesh/triangle_quality.h"

namespace cagefit {

namespace {

constexpr int kMaxPasses = 10;
constexpr int kMostValence = 10;
constexpr double kWorthwhile = 1.2;        // times the worst quality before
constexpr double kTurnCosine = 0.5;        // between a triangle's normals before and after
constexpr double kNeedleQuality = 0.05;    // below, the normal says nothing
constexpr double kCornerNeedle = 0.1;      // for the sake of which corners may merge
constexpr double kCornerDistance = 0.005;  // of corners that may merge, in diagonals

// A triangle of vertices before the change and after it.
struct Changed {
  Eigen::Vector3i before, after;
};

struct Change {
  std::vector<Changed> triangles;  // that stay
  std::vector<int32_t> indices;    // of these
  std::vector<int32_t> removed;    // triangles
  int32_t moved = -1;              // vertex, to `position`
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  int32_t gone = -1;                    // vertex that becomes `moved`
  int32_t taken_up = -1, by_edge = -1;  // vertex that becomes part of a crease edge
  double quality = 0;                   // of the worst triangle after the change
};

// One pass: changes that share no vertex, so that the topology at its start stays true.
class Pass {
 public:
  Pass(const FineSurface& surface, double quality, TaggedMesh* tagged, Topology topology)
      : surface_(surface),
        least_(quality),
        tagged_(*tagged),
        V_(tagged->mesh.vertices),
        T_(tagged->mesh.triangles),
        topology_(std::move(topology)),
        crease_(topology_.edge_count(), 0),
        split_by_(topology_.edge_count(), -1),
        curves_(V_.cols(), 0),
        corner_(V_.cols(), 0),
        touched_(V_.cols(), 0),
        merged_into_(V_.cols()),
        removed_(T_.cols(), 0) {
    for (const auto& [a, b] : tagged->tags.edges) crease_[topology_.FindEdge(a, b)] = 1;
    for (int32_t e = 0; e < topology_.edge_count(); ++e) {
      if (!IsCurve(e)) continue;
      for (const int32_t v : topology_.edge(e)) ++curves_[v];
    }
    for (const int32_t v : tagged->tags.corners) corner_[v] = 1;
    for (int32_t v = 0; v < V_.cols(); ++v) merged_into_[v] = v;
  }

  // Whether anything changed.
  bool Run() {
    std::vector<std::pair<double, int32_t>> poor;
    for (int32_t f = 0; f < T_.cols(); ++f) {
      const double quality = Quality(T_.col(f));
      if (quality < least_) poor.emplace_back(quality, f);
    }
    std::sort(poor.begin(), poor.end());
    bool any = false;
    for (const auto& [quality, f] : poor) any = Improve(f) || any;
    if (any) Compact();
    return any;
  }

 private:
  enum class Freedom : char { kSurface, kCurve, kNone };

  Freedom FreedomOf(int32_t v) const {
    if (corner_[v] || (curves_[v] != 0 && curves_[v] != 2)) return Freedom::kNone;
    return curves_[v] == 2 ? Freedom::kCurve : Freedom::kSurface;
  }
  bool IsCurve(int32_t e) const { return crease_[e] || topology_.IsBoundaryEdge(e); }
  bool IsCurve(int32_t a, int32_t b) const {
    const int32_t e = topology_.FindEdge(a, b);
    return e != Topology::kNone && IsCurve(e);
  }
  int LeastValence(int32_t v) const { return topology_.IsBoundaryVertex(v) ? 2 : 3; }

  double Quality(const Eigen::Vector3i& t) const {
    return TriangleQuality(V_.col(t[0]), V_.col(t[1]), V_.col(t[2]));
  }

  // Triangles around v.
  std::vector<int32_t> Fan(int32_t v) const {
    std::vector<int32_t> fan;
    for (const int32_t e : topology_.RingEdges(v)) {
      for (const int32_t f : topology_.edge_triangles(e)) {
        if (f != Topology::kNone && std::find(fan.begin(), fan.end(), f) == fan.end()) {
          fan.push_back(f);
        }
      }
    }
    return fan;
  }

  static bool Has(const Eigen::Vector3i& t, int32_t v) { return (t.array() == v).any(); }

  // Adds triangles of `fan` that `change` leaves, with `from` replaced by `to`.
  void Keep(const std::vector<int32_t>& fan, int32_t from, int32_t to, Change* change) const {
    for (const int32_t f : fan) {
      const auto& removed = change->removed;
      if (std::find(removed.begin(), removed.end(), f) != removed.end()) continue;
      Changed changed = {T_.col(f), T_.col(f)};
      for (int c = 0; c < 3; ++c) {
        if (changed.after[c] == from) changed.after[c] = to;
      }
      change->triangles.push_back(changed);
      change->indices.push_back(f);
    }
  }

  bool IsFree(const Change& change) const {
    const auto free = [&](const Eigen::Vector3i& t) {
      return !touched_[t[0]] && !touched_[t[1]] && !touched_[t[2]];
    };
    for (const Changed& changed : change.triangles) {
      if (!free(changed.before) || !free(changed.after)) return false;
    }
    for (const int32_t f : change.removed) {
      if (!free(T_.col(f))) return false;
    }
    return true;
  }

  // Sets the change's quality and says whether it makes things better without turning a triangle.
  bool Evaluate(Change* change) const {
    const auto at = [&](int32_t v) {
      return v == change->moved ? change->position : Eigen::Vector3d(V_.col(v));
    };
    double before = 1;
    for (const int32_t f : change->removed) before = std::min(before, Quality(T_.col(f)));
    change->quality = 1;
    for (const Changed& changed : change->triangles) {
      const double old_quality = Quality(changed.before);
      before = std::min(before, old_quality);
      const Eigen::Vector3d p[3] = {at(changed.after[0]), at(changed.after[1]),
                                    at(changed.after[2])};
      change->quality = std::min(change->quality, TriangleQuality(p[0], p[1], p[2]));
    }
    if (!(change->quality > kWorthwhile * before)) return false;
    for (const Changed& changed : change->triangles) {
      const auto& t = changed.before;
      const Eigen::Vector3d p[3] = {at(changed.after[0]), at(changed.after[1]),
                                    at(changed.after[2])};
      const Eigen::Vector3d n = (p[1] - p[0]).cross(p[2] - p[0]);
      const Eigen::Vector3d old =
          Quality(t) > kNeedleQuality
              ? (V_.col(t[1]) - V_.col(t[0])).cross(V_.col(t[2]) - V_.col(t[0])).eval()
              : surface_.NormalAt((p[0] + p[1] + p[2]) / 3);
      if (!(n.dot(old) >= kTurnCosine * n.norm() * old.norm())) return false;
    }
    return true;
  }

  void Consider(Change change, Change* best) const {
    if (IsFree(change) && Evaluate(&change) && change.quality > best->quality) {
      *best = std::move(change);
    }
  }

  // Edge of half-edge h = (a b) of triangle (a b c), with d across.
  void ConsiderFlip(int32_t h, Change* best) const {
    const int32_t g = topology_.opposite(h);
    if (g == Topology::kNone || IsCurve(topology_.triangle_edge(h / 3, h % 3))) return;
    const int32_t a = T_(h % 3, h / 3), b = T_((h + 1) % 3, h / 3), c = T_((h + 2) % 3, h / 3);
    const int32_t d = T_((g % 3 + 2) % 3, g / 3);
    if (topology_.FindEdge(c, d) != Topology::kNone) return;
    if (topology_.Valence(a) <= LeastValence(a) || topology_.Valence(b) <= LeastValence(b)) return;
    if (std::max(topology_.Valence(c), topology_.Valence(d)) >= kMostValence) return;
    Change change;
    change.triangles = {{T_.col(h / 3), {a, d, c}}, {T_.col(g / 3), {d, b, c}}};
    change.indices = {h / 3, g / 3};
    Consider(std::move(change), best);
  }

  // Whether `gone` may become `kept`, by topology: CollapseEdges says why.
  bool MayCollapse(int32_t kept, int32_t gone) const {
    const int32_t e = topology_.FindEdge(kept, gone);
    const int shared = topology_.IsBoundaryEdge(e) ? 1 : 2;
    int common = 0;
    for (const int32_t v : topology_.Ring(kept)) {
      if (topology_.FindEdge(v, gone) == Topology::kNone) continue;
      ++common;
      if (topology_.Valence(v) - 1 < LeastValence(v)) return false;
      if (IsCurve(v, kept) && IsCurve(v, gone)) return false;
    }
    if (common != shared) return false;
    const bool kept_open = topology_.IsBoundaryVertex(kept);
    const bool gone_open = topology_.IsBoundaryVertex(gone);
    if (kept_open && gone_open && shared == 2) return false;
    const int valence = topology_.Valence(kept) + topology_.Valence(gone) - common - 2;
    return valence <= kMostValence && valence >= (kept_open || gone_open ? 2 : 3);
  }

  // kept: the one with less freedom.
  void ConsiderCollapse(int32_t kept, int32_t gone, bool of_needle, Change* best) const {
    const Freedom freedom = FreedomOf(kept);
    const bool alike = freedom == FreedomOf(gone);
    const Eigen::Vector3d along = V_.col(gone) - V_.col(kept);
    if (FreedomOf(gone) != Freedom::kSurface) {
      if (!IsCurve(kept, gone)) return;
      if (freedom == Freedom::kNone && alike &&
          !(of_needle && along.norm() < kCornerDistance * surface_.diagonal())) {
        return;
      }
    }
    if (!MayCollapse(kept, gone)) return;
    Change change;
    for (const int32_t f : topology_.edge_triangles(topology_.FindEdge(kept, gone))) {
      if (f != Topology::kNone) change.removed.push_back(f);
    }
    Keep(Fan(kept), kept, kept, &change);
    Keep(Fan(gone), gone, kept, &change);
    change.moved = kept;
    change.gone = gone;
    change.position = V_.col(kept);
    Consider(change, best);
    if (!alike) return;
    change.position = V_.col(gone);
    Consider(change, best);
    if (freedom == Freedom::kNone) return;
    const Eigen::Vector3d middle = V_.col(kept) + 0.5 * along;
    const auto on = freedom == Freedom::kCurve
                        ? surface_.NearestOnCurve(middle, along, along.norm())
                        : surface_.Nearest(middle, along.norm());
    if (!on.has_value()) return;
    change.position = *on;
    Consider(std::move(change), best);
  }

  // c of triangle (a b c) becomes part of the curve along its half-edge h = (a b):
  //
  //      c               / \          a===b of a curve becomes a===c===b; d, which a boundary does
  //    /   \    to     a=_c_=b        not have, is joined to c.
  //   a=====b           \ | /
  //    \   /             \|/
  //      d                d
  void ConsiderTakingUp(int32_t h, Change* best) const {
    const int32_t edge = topology_.triangle_edge(h / 3, h % 3);
    if (!IsCurve(edge)) return;
    const int32_t a = T_(h % 3, h / 3), b = T_((h + 1) % 3, h / 3), c = T_((h + 2) % 3, h / 3);
    if (FreedomOf(c) != Freedom::kSurface) return;
    const int32_t g = topology_.opposite(h);
    const Eigen::Vector3d along = V_.col(b) - V_.col(a);
    const auto on = surface_.NearestOnCurve(V_.col(c), along, along.norm());
    if (!on.has_value()) return;
    Change change;
    change.removed = {h / 3};
    change.moved = c;
    change.position = *on;
    change.taken_up = c;
    change.by_edge = edge;
    Keep(Fan(c), c, c, &change);
    if (g == Topology::kNone) {
      // The triangle goes and with it the edge.
      if (topology_.Valence(a) <= 2 || topology_.Valence(b) <= 2) return;
      Consider(std::move(change), best);
      return;
    }
    const int32_t d = T_((g % 3 + 2) % 3, g / 3);
    if (topology_.FindEdge(c, d) != Topology::kNone) return;
    if (topology_.Valence(a) <= LeastValence(a) || topology_.Valence(b) <= LeastValence(b)) return;
    if (std::max(topology_.Valence(c), topology_.Valence(d)) >= kMostValence) return;
    change.removed.clear();
    change.triangles.push_back({T_.col(h / 3), {a, d, c}});
    change.indices.push_back(h / 3);
    change.triangles.push_back({T_.col(g / 3), {d, b, c}});
    change.indices.push_back(g / 3);
    Consider(std::move(change), best);
  }

  bool Improve(int32_t f) {
    const bool of_needle = Quality(T_.col(f)) < kCornerNeedle;
    const Eigen::Vector3i t = T_.col(f);
    if (touched_[t[0]] || touched_[t[1]] || touched_[t[2]]) return false;
    Change best;
    for (int c = 0; c < 3; ++c) {
      const int32_t a = t[c], b = t[(c + 1) % 3];
      ConsiderFlip(3 * f + c, &best);
      ConsiderTakingUp(3 * f + c, &best);
      const bool keep_a = FreedomOf(a) >= FreedomOf(b);
      ConsiderCollapse(keep_a ? a : b, keep_a ? b : a, of_needle, &best);
    }
    if (!(best.quality > 0)) return false;
    Apply(best);
    return true;
  }

  void Apply(const Change& change) {
    for (const int32_t f : change.removed) {
      removed_[f] = 1;
      for (int c = 0; c < 3; ++c) touched_[T_(c, f)] = 1;
    }
    for (size_t k = 0; k < change.triangles.size(); ++k) {
      const Changed& changed = change.triangles[k];
      T_.col(change.indices[k]) = changed.after;
      for (int c = 0; c < 3; ++c) touched_[changed.before[c]] = touched_[changed.after[c]] = 1;
    }
    if (change.moved >= 0) V_.col(change.moved) = change.position;
    if (change.gone >= 0) {
      touched_[change.gone] = 1;
      merged_into_[change.gone] = change.moved;
      corner_[change.moved] = corner_[change.moved] || corner_[change.gone];
    }
    if (change.by_edge >= 0) split_by_[change.by_edge] = change.taken_up;
  }

  // Leaves out what is gone.
  void Compact() {
    std::vector<int32_t> index(V_.cols(), -1);
    TriangleMesh out;
    out.vertices.resize(3, V_.cols());
    out.triangles.resize(3, T_.cols());
    int32_t vertices = 0;
    int64_t triangles = 0;
    for (int64_t f = 0; f < T_.cols(); ++f) {
      if (removed_[f]) continue;
      for (int c = 0; c < 3; ++c) {
        int32_t& i = index[T_(c, f)];
        if (i < 0) {
          i = vertices++;
          out.vertices.col(i) = V_.col(T_(c, f));
        }
        out.triangles(c, triangles) = i;
      }
      ++triangles;
    }
    out.vertices.conservativeResize(3, vertices);
    out.triangles.conservativeResize(3, triangles);
    CreaseTags tags;
    const auto add = [&](int32_t a, int32_t b) {
      a = index[merged_into_[a]];
      b = index[merged_into_[b]];
      if (a != b) tags.edges.push_back({a, b});
    };
    for (int32_t e = 0; e < topology_.edge_count(); ++e) {
      if (!crease_[e]) continue;
      const auto& [a, b] = topology_.edge(e);
      if (split_by_[e] < 0) {
        add(a, b);
      } else {
        add(a, split_by_[e]);
        add(split_by_[e], b);
      }
    }
    for (int32_t v = 0; v < V_.cols(); ++v) {
      if (corner_[v] && merged_into_[v] == v) tags.corners.push_back(index[v]);
    }
    tagged_ = {std::move(out), std::move(tags)};
  }

  const FineSurface& surface_;
  const double least_;
  TaggedMesh& tagged_;
  Points3d& V_;
  Triangles& T_;
  const Topology topology_;        // at the start of the pass
  std::vector<char> crease_;       // edges
  std::vector<int32_t> split_by_;  // edges: the vertex taken up
  std::vector<int> curves_;        // boundary and crease edges at a vertex
  std::vector<char> corner_, touched_;
  std::vector<int32_t> merged_into_;  // vertices; itself for one that stays
  std::vector<char> removed_;         // triangles
};

}  // namespace

void RemoveNeedles(const FineSurface& surface, double quality, TaggedMesh* tagged) {
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    auto topology = Topology::Create(static_cast<int32_t>(tagged->mesh.vertices.cols()),
                                     tagged->mesh.triangles);
    if (!topology.ok() || !Pass(surface, quality, tagged, *std::move(topology)).Run()) return;
  }
}

}  // namespace cagefit
