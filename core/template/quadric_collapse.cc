#include "core/template/quadric_collapse.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

#include "absl/container/inlined_vector.h"
#include "core/mesh/triangle_quality.h"

namespace cagefit {

namespace {

constexpr double kCurveWeight = 10;  // of the planes that hold boundaries and creases, relative to
                                     // triangle planes
constexpr double kVertexWeight = 1e-3;  // of the distance to original vertices

// What a collapse must leave behind. Where the strict rules leave too many vertices, the looser
// ones go on.
struct Rules {
  int max_valence;
  double least_cosine;   // between a triangle's normals before and after
  double least_quality;  // TriangleQuality
  double max_length;     // of the edge, in mean edge lengths of the input
};
constexpr double kAnyLength = 1e300;
constexpr Rules kRules[] = {
    // Isosurfaces are full of needles, whose short sides go first: they would block what is around
    // them and stay as clumps of tiny triangles.
    {12, -1, 0, 0.4},
    {9, 0.2, 0.12, kAnyLength},
    {12, 0, 0.01, kAnyLength}};
// The normal of a needle says nothing.
constexpr double kNeedleQuality = 0.05;

// x^T A x - 2 b^T x + c
struct Quadric {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0;

  void AddPlane(const Eigen::Vector3d& normal, const Eigen::Vector3d& point, double weight) {
    const double d = normal.dot(point);
    A += weight * normal * normal.transpose();
    b += weight * d * normal;
    c += weight * d * d;
  }
  void AddPoint(const Eigen::Vector3d& point, double weight) {
    A.diagonal().array() += weight;
    b += weight * point;
    c += weight * point.squaredNorm();
  }
  Quadric operator+(const Quadric& o) const { return {A + o.A, b + o.b, c + o.c}; }
  double At(const Eigen::Vector3d& x) const { return x.dot(A * x) - 2 * b.dot(x) + c; }
};

struct Candidate {
  double cost;
  int32_t a, b;
  uint32_t stamp_a, stamp_b;
  bool operator>(const Candidate& o) const {
    return std::tie(cost, a, b) > std::tie(o.cost, o.a, o.b);
  }
};

using IndexList = absl::InlinedVector<int32_t, 8>;

bool Contains(const IndexList& list, int32_t value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

void Erase(int32_t value, IndexList* list) {
  const auto found = std::find(list->begin(), list->end(), value);
  if (found != list->end()) list->erase(found);
}

// How a vertex may move: anywhere, along the boundary or crease that runs through it, or not at all
// (a corner, or the end of a crease).
enum class Freedom : char { kSurface, kCurve, kNone };

class Collapser {
 public:
  explicit Collapser(const TaggedMesh& tagged)
      : V_(tagged.mesh.vertices),
        T_(tagged.mesh.triangles),
        alive_(T_.cols(), 1),
        faces_(V_.cols()),
        curve_(V_.cols()),
        blocked_(V_.cols()),
        freedom_(V_.cols(), Freedom::kSurface),
        boundary_(V_.cols(), 0),
        corner_(V_.cols(), 0),
        stamp_(V_.cols(), 0),
        quadric_(V_.cols()),
        left_(V_.cols()),
        // Far from the origin quadrics would lose their digits.
        origin_(V_.cols() > 0 ? V_.rowwise().mean().eval() : Eigen::Vector3d::Zero()) {
    V_.colwise() -= origin_;
    for (int32_t f = 0; f < T_.cols(); ++f) {
      for (int c = 0; c < 3; ++c) faces_[T_(c, f)].push_back(f);
    }
    FindCurves(tagged.tags);
    AddQuadrics();
    double sum = 0;
    for (int64_t k = 0; k < T_.size(); ++k) {
      sum += (V_.col(T_(k % 3, k / 3)) - V_.col(T_((k + 1) % 3, k / 3))).norm();
    }
    mean_edge_ = sum / static_cast<double>(std::max<int64_t>(1, T_.size()));
  }

  void Run(int64_t vertices, const Rules& rules) {
    rules_ = rules;
    max_length_ = rules.max_length * mean_edge_;
    std::vector<Candidate> all;
    queue_ = {};
    for (IndexList& list : blocked_) list.clear();
    for (int32_t v = 0; v < V_.cols(); ++v) {
      Neighbors(v, &near_a_);
      for (const int32_t n : near_a_) {
        if (n > v) AddCandidate(v, n, &all);
      }
    }
    queue_ = decltype(queue_)(std::greater<>(), std::move(all));
    while (left_ > vertices && !queue_.empty()) {
      const Candidate top = queue_.top();
      queue_.pop();
      if (top.stamp_a != stamp_[top.a] || top.stamp_b != stamp_[top.b]) continue;
      const Eigen::Vector3d position = Position(top.a, top.b);
      if (IsLegal(top.a, top.b, position)) {
        Collapse(top.a, top.b, position);
      } else {
        blocked_[top.a].push_back(top.b);
        blocked_[top.b].push_back(top.a);
      }
    }
  }

  TaggedMesh Result() const {
    TaggedMesh out;
    std::vector<int32_t> index(V_.cols(), -1);
    Points3d& V = out.mesh.vertices;
    Triangles& T = out.mesh.triangles;
    V.resize(3, left_);
    T.resize(3, std::count(alive_.begin(), alive_.end(), 1));
    int32_t vertices = 0;
    int64_t triangles = 0;
    for (int32_t f = 0; f < T_.cols(); ++f) {
      if (!alive_[f]) continue;
      for (int c = 0; c < 3; ++c) {
        int32_t& i = index[T_(c, f)];
        if (i < 0) {
          i = vertices++;
          V.col(i) = V_.col(T_(c, f)) + origin_;
        }
        T(c, triangles) = i;
      }
      ++triangles;
    }
    V.conservativeResize(3, vertices);
    for (int32_t v = 0; v < V_.cols(); ++v) {
      if (index[v] < 0) continue;
      for (const int32_t n : curve_[v]) {
        if (n > v && SharedFaces(v, n) == 2) out.tags.edges.push_back({index[v], index[n]});
      }
      if (corner_[v]) out.tags.corners.push_back(index[v]);
    }
    return out;
  }

 private:
  bool Has(int32_t f, int32_t v) const { return T_(0, f) == v || T_(1, f) == v || T_(2, f) == v; }

  // Sorted.
  void Neighbors(int32_t v, std::vector<int32_t>* out) const {
    out->clear();
    for (const int32_t f : faces_[v]) {
      for (int c = 0; c < 3; ++c) {
        if (T_(c, f) != v) out->push_back(T_(c, f));
      }
    }
    std::sort(out->begin(), out->end());
    out->erase(std::unique(out->begin(), out->end()), out->end());
  }

  int SharedFaces(int32_t a, int32_t b) const {
    return static_cast<int>(
        std::count_if(faces_[a].begin(), faces_[a].end(), [&](int32_t f) { return Has(f, b); }));
  }

  // A vertex inside a manifold mesh has as many neighbours as faces, one on the boundary one more.
  int Valence(int32_t v) const { return static_cast<int>(faces_[v].size()) + boundary_[v]; }

  void FindCurves(const CreaseTags& tags) {
    const auto join = [this](int32_t a, int32_t b) {
      if (Contains(curve_[a], b)) return;
      curve_[a].push_back(b);
      curve_[b].push_back(a);
    };
    for (int32_t f = 0; f < T_.cols(); ++f) {
      for (int c = 0; c < 3; ++c) {
        const int32_t v = T_(c, f), w = T_((c + 1) % 3, f);
        if (SharedFaces(v, w) > 1) continue;
        boundary_[v] = boundary_[w] = 1;
        join(v, w);
      }
    }
    for (const auto& [a, b] : tags.edges) join(a, b);
    for (const int32_t v : tags.corners) corner_[v] = 1;
    for (int32_t v = 0; v < V_.cols(); ++v) {
      if (curve_[v].empty() && !corner_[v]) continue;
      freedom_[v] = curve_[v].size() == 2 && !corner_[v] ? Freedom::kCurve : Freedom::kNone;
    }
  }

  void AddQuadrics() {
    for (int32_t f = 0; f < T_.cols(); ++f) {
      const Eigen::Vector3d p[3] = {V_.col(T_(0, f)), V_.col(T_(1, f)), V_.col(T_(2, f))};
      const Eigen::Vector3d cross = (p[1] - p[0]).cross(p[2] - p[0]);
      const double area = 0.5 * cross.norm();
      if (!(area > 0)) continue;
      const Eigen::Vector3d normal = cross / (2 * area);
      for (int c = 0; c < 3; ++c) {
        const int32_t v = T_(c, f), w = T_((c + 1) % 3, f);
        quadric_[v].AddPlane(normal, p[c], area / 3);
        quadric_[v].AddPoint(p[c], kVertexWeight * area / 3);
        if (!Contains(curve_[v], w)) continue;
        const Eigen::Vector3d along = p[(c + 1) % 3] - p[c];
        const Eigen::Vector3d across = along.cross(normal).normalized();
        for (const int32_t end : {v, w}) {
          quadric_[end].AddPlane(across, p[c], kCurveWeight * along.squaredNorm());
        }
      }
    }
  }

  // Where the vertex that edge (a b) collapses to lies.
  Eigen::Vector3d Position(int32_t a, int32_t b) const {
    if (freedom_[a] != freedom_[b]) return V_.col(freedom_[a] > freedom_[b] ? a : b);
    const Quadric q = quadric_[a] + quadric_[b];
    const Eigen::Vector3d middle = 0.5 * (V_.col(a) + V_.col(b));
    const Eigen::Vector3d best = q.A.inverse() * q.b;
    // A nearly singular system throws its solution far away.
    const double reach = 2 * (V_.col(a) - V_.col(b)).norm();
    return best.allFinite() && (best - middle).norm() < reach ? best : middle;
  }

  // Whether the edge, whatever its neighbourhood, never collapses: it would pinch the surface or
  // join two curves.
  bool IsForbidden(int32_t a, int32_t b) const {
    if (freedom_[a] == Freedom::kSurface || freedom_[b] == Freedom::kSurface) return false;
    return (freedom_[a] == Freedom::kNone && freedom_[b] == Freedom::kNone) ||
           !Contains(curve_[a], b);
  }

  void AddCandidate(int32_t a, int32_t b, std::vector<Candidate>* out) const {
    if (IsForbidden(a, b) || (V_.col(a) - V_.col(b)).norm() > max_length_) return;
    const double cost = (quadric_[a] + quadric_[b]).At(Position(a, b));
    out->push_back({std::max(0.0, cost), a, b, stamp_[a], stamp_[b]});
  }

  bool IsLegal(int32_t a, int32_t b, const Eigen::Vector3d& position) {
    Neighbors(a, &near_a_);
    Neighbors(b, &near_b_);
    common_.clear();
    std::set_intersection(near_a_.begin(), near_a_.end(), near_b_.begin(), near_b_.end(),
                          std::back_inserter(common_));
    const int shared = SharedFaces(a, b);
    if (static_cast<int>(common_.size()) != shared) return false;
    if (boundary_[a] && boundary_[b] && shared != 1) return false;
    const int valence = static_cast<int>(near_a_.size() + near_b_.size() - common_.size()) - 2;
    const bool on_boundary = boundary_[a] || boundary_[b];
    if (valence > rules_.max_valence || valence < (on_boundary ? 2 : 3)) return false;
    for (const int32_t v : common_) {
      if (Valence(v) - 1 < (boundary_[v] ? 2 : 3)) return false;
      // Two curves would fall together.
      if (Contains(curve_[v], a) && Contains(curve_[v], b)) return false;
    }
    // A boundary loop keeps at least three edges.
    if (boundary_[a] && boundary_[b] && valence < 3 && left_ < 5) return false;
    return KeepsShape(a, b, position) && KeepsShape(b, a, position);
  }

  // Triangles of `moved` that stay must not turn over or become needles.
  bool KeepsShape(int32_t moved, int32_t other, const Eigen::Vector3d& position) const {
    for (const int32_t f : faces_[moved]) {
      if (Has(f, other)) continue;
      Eigen::Vector3d p[3], q[3];
      for (int c = 0; c < 3; ++c) {
        p[c] = V_.col(T_(c, f));
        q[c] = T_(c, f) == moved ? position : p[c];
      }
      const Eigen::Vector3d before = (p[1] - p[0]).cross(p[2] - p[0]);
      const Eigen::Vector3d after = (q[1] - q[0]).cross(q[2] - q[0]);
      const double quality = TriangleQuality(q[0], q[1], q[2]),
                   old_quality = TriangleQuality(p[0], p[1], p[2]);
      if (old_quality > kNeedleQuality &&
          after.dot(before) <= rules_.least_cosine * after.norm() * before.norm()) {
        return false;
      }
      if (quality < rules_.least_quality && quality < old_quality) return false;
    }
    return true;
  }

  // b becomes a.
  void Collapse(int32_t a, int32_t b, const Eigen::Vector3d& position) {
    for (const int32_t f : faces_[b]) {
      if (Has(f, a)) {
        alive_[f] = 0;
        for (int c = 0; c < 3; ++c) {
          if (T_(c, f) != b) Erase(f, &faces_[T_(c, f)]);
        }
        continue;
      }
      for (int c = 0; c < 3; ++c) {
        if (T_(c, f) == b) T_(c, f) = a;
      }
      faces_[a].push_back(f);
    }
    faces_[b].clear();
    Erase(b, &curve_[a]);
    for (const int32_t n : curve_[b]) {
      if (n == a) continue;
      std::replace(curve_[n].begin(), curve_[n].end(), b, a);
      curve_[a].push_back(n);
    }
    curve_[b].clear();
    V_.col(a) = position;
    quadric_[a] = quadric_[a] + quadric_[b];
    freedom_[a] = std::max(freedom_[a], freedom_[b]);
    boundary_[a] = boundary_[a] || boundary_[b];
    corner_[a] = corner_[a] || corner_[b];
    --left_;
    ++stamp_[a];
    ++stamp_[b];
    Renew(a);
  }

  // Candidates at the vertex are made anew, and those of its neighbours that were blocked.
  void Renew(int32_t a) {
    fresh_.clear();
    blocked_[a].clear();
    Neighbors(a, &near_a_);
    for (const int32_t n : near_a_) {
      AddCandidate(std::min(a, n), std::max(a, n), &fresh_);
      for (const int32_t m : blocked_[n]) {
        if (m == a || faces_[m].empty()) continue;
        Erase(n, &blocked_[m]);
        AddCandidate(std::min(n, m), std::max(n, m), &fresh_);
      }
      blocked_[n].clear();
    }
    for (const Candidate& candidate : fresh_) queue_.push(candidate);
  }

  Rules rules_ = kRules[0];
  double mean_edge_ = 0, max_length_ = 0;
  Points3d V_;
  Triangles T_;
  std::vector<char> alive_;         // triangles
  std::vector<IndexList> faces_;    // of a vertex; none when it is gone
  std::vector<IndexList> curve_;    // neighbours along boundaries and creases
  std::vector<IndexList> blocked_;  // neighbours to which the edge must not collapse for now
  std::vector<Freedom> freedom_;
  std::vector<char> boundary_, corner_;
  std::vector<uint32_t> stamp_;
  std::vector<Quadric> quadric_;
  int64_t left_;
  Eigen::Vector3d origin_;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> queue_;
  std::vector<int32_t> near_a_, near_b_, common_;  // buffers
  std::vector<Candidate> fresh_;
};

}  // namespace

TaggedMesh CollapseEdges(const TaggedMesh& mesh, int64_t vertices) {
  Collapser collapser(mesh);
  for (const Rules& rules : kRules) collapser.Run(vertices, rules);
  return collapser.Result();
}

}  // namespace cagefit
