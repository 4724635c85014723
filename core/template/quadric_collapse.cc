#include "core/template/quadric_collapse.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

namespace cagefit {

namespace {

constexpr double kBoundaryWeight =
    10;  // of the planes that hold the boundary curve, relative to triangle planes
constexpr double kVertexWeight = 1e-3;  // of the distance to original vertices

// What a collapse must leave behind. Where the strict rules leave too many vertices, the looser
// ones go on.
struct Rules {
  int max_valence;
  double least_cosine;   // between a triangle's normals before and after
  double least_quality;  // 4 sqrt(3) area / sum of squared sides: 1 for an equilateral triangle
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

double Quality(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const double sides = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
  return sides > 0 ? 2 * std::sqrt(3.0) * (b - a).cross(c - a).norm() / sides : 0;
}

struct Candidate {
  double cost;
  int32_t a, b;
  uint32_t stamp_a, stamp_b;
  Eigen::Vector3d position;
  bool operator>(const Candidate& o) const {
    return std::tie(cost, a, b) > std::tie(o.cost, o.a, o.b);
  }
};

class Collapser {
 public:
  explicit Collapser(const TriangleMesh& mesh)
      : V_(mesh.vertices),
        T_(mesh.triangles),
        alive_(mesh.triangles.cols(), 1),
        faces_(mesh.vertices.cols()),
        boundary_(mesh.vertices.cols(), 0),
        stamp_(mesh.vertices.cols(), 0),
        quadric_(mesh.vertices.cols()),
        left_(mesh.vertices.cols()) {
    for (int32_t f = 0; f < T_.cols(); ++f) {
      for (int c = 0; c < 3; ++c) faces_[T_(c, f)].push_back(f);
    }
    AddQuadrics();
    double sum = 0;
    for (int64_t k = 0; k < T_.size(); ++k) {
      sum += (V_.col(T_(k % 3, k / 3)) - V_.col(T_((k + 1) % 3, k / 3))).norm();
    }
    mean_edge_ = sum / static_cast<double>(std::max<int64_t>(1, T_.size()));
  }

  void Run(int64_t vertices, const Rules& rules) {
    rules_ = rules;
    queue_ = {};
    max_length_ = rules.max_length * mean_edge_;
    for (int32_t v = 0; v < V_.cols(); ++v) {
      for (const int32_t n : Neighbors(v)) {
        if (n > v) Push(v, n);
      }
    }
    while (left_ > vertices && !queue_.empty()) {
      const Candidate top = queue_.top();
      queue_.pop();
      if (top.stamp_a != stamp_[top.a] || top.stamp_b != stamp_[top.b]) continue;
      if (faces_[top.a].empty() || faces_[top.b].empty()) continue;
      if (IsLegal(top)) Collapse(top);
    }
  }

  TriangleMesh Result() const {
    TriangleMesh out;
    std::vector<int32_t> index(V_.cols(), -1);
    out.vertices.resize(3, left_);
    out.triangles.resize(3, std::count(alive_.begin(), alive_.end(), 1));
    int32_t vertices = 0;
    int64_t triangles = 0;
    for (int32_t f = 0; f < T_.cols(); ++f) {
      if (!alive_[f]) continue;
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
    return out;
  }

 private:
  bool Has(int32_t f, int32_t v) const { return T_(0, f) == v || T_(1, f) == v || T_(2, f) == v; }

  std::vector<int32_t> Neighbors(int32_t v) const {
    std::vector<int32_t> out;
    for (const int32_t f : faces_[v]) {
      for (int c = 0; c < 3; ++c) {
        if (T_(c, f) != v) out.push_back(T_(c, f));
      }
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  int SharedFaces(int32_t a, int32_t b) const {
    return static_cast<int>(
        std::count_if(faces_[a].begin(), faces_[a].end(), [&](int32_t f) { return Has(f, b); }));
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
        if (SharedFaces(v, w) > 1) continue;
        boundary_[v] = boundary_[w] = 1;
        const Eigen::Vector3d along = p[(c + 1) % 3] - p[c];
        const Eigen::Vector3d across = along.cross(normal).normalized();
        for (const int32_t end : {v, w}) {
          quadric_[end].AddPlane(across, p[c], kBoundaryWeight * along.squaredNorm());
        }
      }
    }
  }

  void Push(int32_t a, int32_t b) {
    if (boundary_[a] && boundary_[b] && SharedFaces(a, b) != 1) return;  // would pinch the surface
    if ((V_.col(a) - V_.col(b)).norm() > max_length_) return;
    const Quadric q = quadric_[a] + quadric_[b];
    Candidate candidate{0, a, b, stamp_[a], stamp_[b], Eigen::Vector3d::Zero()};
    if (boundary_[a] != boundary_[b]) {
      candidate.position = V_.col(boundary_[a] ? a : b);
    } else {
      const Eigen::Vector3d middle = 0.5 * (V_.col(a) + V_.col(b));
      const double length = (V_.col(a) - V_.col(b)).norm();
      const Eigen::LDLT<Eigen::Matrix3d> solver(q.A);
      const Eigen::Vector3d best = solver.solve(q.b);
      // A nearly singular system throws its solution far away.
      candidate.position = best.allFinite() && (best - middle).norm() < 2 * length ? best : middle;
    }
    candidate.cost = std::max(0.0, q.At(candidate.position));
    queue_.push(candidate);
  }

  bool IsLegal(const Candidate& e) const {
    const std::vector<int32_t> near_a = Neighbors(e.a), near_b = Neighbors(e.b);
    std::vector<int32_t> common, all;
    std::set_intersection(near_a.begin(), near_a.end(), near_b.begin(), near_b.end(),
                          std::back_inserter(common));
    const int shared = SharedFaces(e.a, e.b);
    if (static_cast<int>(common.size()) != shared) return false;
    if (boundary_[e.a] && boundary_[e.b] && shared != 1) return false;
    const int valence = static_cast<int>(near_a.size() + near_b.size() - common.size()) - 2;
    const bool on_boundary = boundary_[e.a] || boundary_[e.b];
    if (valence > rules_.max_valence || valence < (on_boundary ? 2 : 3)) return false;
    for (const int32_t v : common) {
      const int after = static_cast<int>(Neighbors(v).size()) - 1;
      if (after < (boundary_[v] ? 2 : 3)) return false;
    }
    // A boundary loop keeps at least three edges.
    if (boundary_[e.a] && boundary_[e.b] && valence < 3 && left_ < 5) return false;
    return KeepsShape(e.a, e.b, e.position) && KeepsShape(e.b, e.a, e.position);
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
      const double quality = Quality(q[0], q[1], q[2]), old_quality = Quality(p[0], p[1], p[2]);
      if (old_quality > kNeedleQuality &&
          after.dot(before) <= rules_.least_cosine * after.norm() * before.norm()) {
        return false;
      }
      if (quality < rules_.least_quality && quality < old_quality) return false;
    }
    return true;
  }

  static void Erase(int32_t f, std::vector<int32_t>* faces) {
    faces->erase(std::find(faces->begin(), faces->end(), f));
  }

  void Collapse(const Candidate& e) {
    for (const int32_t f : faces_[e.b]) {
      if (Has(f, e.a)) {
        alive_[f] = 0;
        for (int c = 0; c < 3; ++c) {
          if (T_(c, f) != e.b) Erase(f, &faces_[T_(c, f)]);
        }
        continue;
      }
      for (int c = 0; c < 3; ++c) {
        if (T_(c, f) == e.b) T_(c, f) = e.a;
      }
      faces_[e.a].push_back(f);
    }
    faces_[e.b].clear();
    V_.col(e.a) = e.position;
    quadric_[e.a] = quadric_[e.a] + quadric_[e.b];
    boundary_[e.a] = boundary_[e.a] || boundary_[e.b];
    --left_;
    // Every candidate at the vertex, and those of its neighbours that it had blocked, is made anew.
    ++stamp_[e.a];
    ++stamp_[e.b];
    const std::vector<int32_t> near = Neighbors(e.a);
    for (const int32_t n : near) ++stamp_[n];
    for (const int32_t n : near) {
      for (const int32_t m : Neighbors(n)) {
        if (m == e.a || m > n || !std::binary_search(near.begin(), near.end(), m)) Push(n, m);
      }
    }
  }

  Rules rules_ = kRules[0];
  double mean_edge_ = 0, max_length_ = 0;
  Points3d V_;
  Triangles T_;
  std::vector<char> alive_;
  std::vector<std::vector<int32_t>> faces_;
  std::vector<char> boundary_;
  std::vector<uint32_t> stamp_;
  std::vector<Quadric> quadric_;
  int64_t left_;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> queue_;
};

}  // namespace

TriangleMesh CollapseEdges(const TriangleMesh& mesh, int64_t vertices) {
  Collapser collapser(mesh);
  for (const Rules& rules : kRules) collapser.Run(vertices, rules);
  return collapser.Result();
}

}  // namespace cagefit
