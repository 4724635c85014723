#include "core/mesh/crease_detection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

namespace cagefit {

namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kWeakShare = 1.0 / 3;    // of the angle that starts a crease
constexpr double kLeastContrast = 0.6;    // edge angle to angle between the sides' mean normals
constexpr double kUsualMultiple = 3;      // of the lower quartile of the angles around an edge
constexpr int kSideRings = 3;             // triangles away from the edge that make up its sides
constexpr double kContinuesCosine = 0.5;  // between a crease and the weaker edge that continues it
constexpr double kCornerCosine = 0.643;   // cos 50 degrees
constexpr double kCapHeight = 0.15;       // of a cap, in longest sides
constexpr double kLeastSpur = 0.02;       // of a dangling end, in diagonals
constexpr double kLeastParallel = 0.2;    // of one that runs beside another crease
constexpr double kBesideCosine = 0.866;   // of creases that meet, for one to run beside the other
constexpr double kLeastLength = 0.1;      // of a connected set of creases, in diagonals
// A set of creases is a part's when it has few loose ends and kinks for its length (in diagonals),
// and turns little from edge to edge in between.
constexpr double kMostFlawsPerDiagonal = 5;
constexpr double kMostMeanTurn = 25 * kDegree;

class Detector {
 public:
  Detector(const Points3d& V, const Topology& topology, double angle)
      : V_(V),
        topology_(topology),
        strong_(angle * kDegree),
        diagonal_(BoundingBox(V).diagonal()),
        mark_(topology.triangle_count(), -1) {
    normals_.resize(3, topology.triangle_count());
    for (int32_t f = 0; f < topology.triangle_count(); ++f) {
      const auto t = topology.triangles().col(f);
      normals_.col(f) = (V.col(t[1]) - V.col(t[0])).cross(V.col(t[2]) - V.col(t[0]));
    }
    angle_.resize(topology.edge_count(), 0);
    for (int32_t e = 0; e < topology.edge_count(); ++e) {
      if (topology.IsBoundaryEdge(e)) continue;
      const auto& [f, g] = topology.edge_triangles(e);
      angle_[e] = Angle(normals_.col(f), normals_.col(g));
    }
  }

  CreaseTags Run(CreaseEffort effort) {
    FindStrong();
    Continue();
    DropLongSidesOfCaps();
    DropSpurs();
    Shape all;
    for (int32_t v = 0; v < topology_.vertex_count(); ++v) AddVertex(v, &all);
    if (effort == CreaseEffort::kOnParts && !all.IsOfPart(diagonal_)) return {};
    DropPoorSets();
    return Tags();
  }

 private:
  static double Angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return std::atan2(a.cross(b).norm(), a.dot(b));
  }

  double Length(int32_t e) const {
    return (V_.col(topology_.edge(e)[0]) - V_.col(topology_.edge(e)[1])).norm();
  }

  int32_t Other(int32_t e, int32_t v) const {
    return topology_.edge(e)[0] == v ? topology_.edge(e)[1] : topology_.edge(e)[0];
  }

  // The sum of the normals (by area) of the triangles around triangle f of edge e that lie on f's
  // side of it. Appends the angles of the edges crossed.
  Eigen::Vector3d SideNormal(int32_t e, int32_t f, std::vector<double>* angles) {
    const Eigen::Vector3d a = V_.col(topology_.edge(e)[0]), b = V_.col(topology_.edge(e)[1]);
    const auto t = topology_.triangles().col(f);
    const Eigen::Vector3d middle = (V_.col(t[0]) + V_.col(t[1]) + V_.col(t[2])) / 3;
    const Eigen::Vector3d along = (b - a).normalized();
    const Eigen::Vector3d away = (middle - a) - along.dot(middle - a) * along;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    ++stamp_;
    std::vector<int32_t>& front = front_;
    front.assign(1, f);
    mark_[f] = stamp_;
    size_t begin = 0;
    for (int ring = 0; ring <= kSideRings; ++ring) {
      const size_t end = front.size();
      for (size_t k = begin; k < end; ++k) {
        sum += normals_.col(front[k]);
        for (int c = 0; c < 3; ++c) {
          const int32_t edge = topology_.triangle_edge(front[k], c);
          const int32_t opposite = topology_.opposite(3 * front[k] + c);
          if (edge == e || opposite == Topology::kNone || mark_[opposite / 3] == stamp_) continue;
          const int32_t g = opposite / 3;
          angles->push_back(angle_[edge]);
          const auto u = topology_.triangles().col(g);
          const Eigen::Vector3d center = (V_.col(u[0]) + V_.col(u[1]) + V_.col(u[2])) / 3;
          // Beyond another sharp edge lies another side.
          if ((center - a).dot(away) <= 0 || angle_[edge] >= strong_) continue;
          mark_[g] = stamp_;
          front.push_back(g);
        }
      }
      begin = end;
    }
    return sum;
  }

  bool TurnsHere(int32_t e) {
    const auto& [f, g] = topology_.edge_triangles(e);
    std::vector<double>& angles = angles_;
    angles.clear();
    const Eigen::Vector3d n = SideNormal(e, f, &angles);
    const Eigen::Vector3d m = SideNormal(e, g, &angles);
    const double far = Angle(n, m);
    if (angle_[e] < kLeastContrast * far || far < kLeastContrast * angle_[e]) return false;
    if (angles.empty()) return true;
    const auto quartile = angles.begin() + static_cast<int64_t>((angles.size() - 1) / 4);
    std::nth_element(angles.begin(), quartile, angles.end());
    return angle_[e] >= kUsualMultiple * *quartile;
  }

  void FindStrong() {
    candidate_.assign(topology_.edge_count(), 0);
    crease_.assign(topology_.edge_count(), 0);
    for (int32_t e = 0; e < topology_.edge_count(); ++e) {
      if (angle_[e] < kWeakShare * strong_ || !TurnsHere(e)) continue;
      candidate_[e] = 1;
      crease_[e] = angle_[e] >= strong_;
    }
  }

  // Cosine between the directions in which edges e and d, which meet at v, run through it.
  double Straightness(int32_t e, int32_t d, int32_t v) const {
    const Eigen::Vector3d in = V_.col(v) - V_.col(Other(e, v));
    const Eigen::Vector3d out = V_.col(Other(d, v)) - V_.col(v);
    return in.dot(out) / std::max(in.norm() * out.norm(), 1e-300);
  }

  void Continue() {
    std::vector<int32_t> open;
    for (int32_t e = 0; e < topology_.edge_count(); ++e) {
      if (crease_[e]) open.push_back(e);
    }
    while (!open.empty()) {
      const int32_t e = open.back();
      open.pop_back();
      for (const int32_t v : topology_.edge(e)) {
        for (const int32_t d : topology_.RingEdges(v)) {
          if (crease_[d] || !candidate_[d] || Straightness(e, d, v) < kContinuesCosine) continue;
          crease_[d] = 1;
          open.push_back(d);
        }
      }
    }
  }

  // A cap that lies along an edge has three sharp sides, of which two lead around the third.
  void DropLongSidesOfCaps() {
    for (int32_t f = 0; f < topology_.triangle_count(); ++f) {
      int32_t longest = topology_.triangle_edge(f, 0);
      bool all = true;
      for (int c = 0; c < 3; ++c) {
        const int32_t e = topology_.triangle_edge(f, c);
        all = all && crease_[e];
        if (Length(e) > Length(longest)) longest = e;
      }
      // Height over the longest side.
      if (all && normals_.col(f).norm() < kCapHeight * Length(longest) * Length(longest)) {
        crease_[longest] = 0;
      }
    }
  }

  int Degree(int32_t v) const {
    int degree = 0;
    for (const int32_t e : topology_.RingEdges(v)) degree += crease_[e];
    return degree;
  }

  // Whether crease e comes to v alongside another crease.
  bool RunsBeside(int32_t e, int32_t v) const {
    for (const int32_t d : topology_.RingEdges(v)) {
      if (d != e && crease_[d] && Straightness(e, d, v) < -kBesideCosine) return true;
    }
    return false;
  }

  // A spur runs from a dangling end to a branch. Long ones go where they run beside the crease that
  // they meet: thin triangles along an edge have two sides that are as sharp.
  void DropSpurs() {
    for (int32_t v = 0; v < topology_.vertex_count(); ++v) {
      if (Degree(v) != 1 || topology_.IsBoundaryVertex(v)) continue;
      std::vector<int32_t> spur;
      double length = 0;
      int32_t at = v;
      do {
        for (const int32_t e : topology_.RingEdges(at)) {
          if (!crease_[e] || (!spur.empty() && e == spur.back())) continue;
          spur.push_back(e);
          break;
        }
        length += Length(spur.back());
        at = Other(spur.back(), at);
      } while (Degree(at) == 2 && length < kLeastParallel * diagonal_);
      if (Degree(at) < 3) continue;
      if (length >= kLeastSpur * diagonal_ &&
          (length >= kLeastParallel * diagonal_ || !RunsBeside(spur.back(), at))) {
        continue;
      }
      for (const int32_t e : spur) crease_[e] = 0;
    }
  }

  // What a set of creases looks like.
  struct Shape {
    double length = 0;  // user units
    int flaws = 0;      // loose ends inside the surface, and kinks
    double turn = 0;    // radians, summed over `joints`
    int joints = 0;     // vertices with two creases that are no kinks

    bool IsOfPart(double diagonal) const {
      return flaws <= kMostFlawsPerDiagonal * length / diagonal && turn <= kMostMeanTurn * joints;
    }
  };

  void AddVertex(int32_t v, Shape* shape) const {
    int32_t crease[2] = {-1, -1};
    int degree = 0;
    for (const int32_t e : topology_.RingEdges(v)) {
      if (!crease_[e]) continue;
      if (degree < 2) crease[degree] = e;
      ++degree;
      shape->length += 0.5 * Length(e);
    }
    if (degree == 1) shape->flaws += !topology_.IsBoundaryVertex(v);
    if (degree != 2) return;
    const double cosine = Straightness(crease[0], crease[1], v);
    if (cosine < kCornerCosine) {
      ++shape->flaws;
    } else {
      shape->turn += std::acos(std::min(1.0, cosine));
      ++shape->joints;
    }
  }

  void DropPoorSets() {
    std::vector<char> seen(topology_.vertex_count(), 0);
    for (int32_t first = 0; first < topology_.vertex_count(); ++first) {
      if (seen[first] || Degree(first) == 0) continue;
      std::vector<int32_t> set = {first};
      seen[first] = 1;
      Shape shape;
      for (size_t k = 0; k < set.size(); ++k) {
        AddVertex(set[k], &shape);
        for (const int32_t e : topology_.RingEdges(set[k])) {
          const int32_t next = Other(e, set[k]);
          if (!crease_[e] || seen[next]) continue;
          seen[next] = 1;
          set.push_back(next);
        }
      }
      if (shape.length >= kLeastLength * diagonal_ && shape.IsOfPart(diagonal_)) continue;
      for (const int32_t v : set) {
        for (const int32_t e : topology_.RingEdges(v)) crease_[e] = 0;
      }
    }
  }

  CreaseTags Tags() const {
    CreaseTags tags;
    for (int32_t e = 0; e < topology_.edge_count(); ++e) {
      if (crease_[e]) tags.edges.push_back(topology_.edge(e));
    }
    for (int32_t v = 0; v < topology_.vertex_count(); ++v) {
      std::vector<int32_t> sharp;
      int creases = 0;
      for (const int32_t e : topology_.RingEdges(v)) {
        creases += crease_[e];
        if (crease_[e] || topology_.IsBoundaryEdge(e)) sharp.push_back(e);
      }
      if (creases == 0) continue;
      if (sharp.size() > 2 ||
          (sharp.size() == 2 && Straightness(sharp[0], sharp[1], v) < kCornerCosine)) {
        tags.corners.push_back(v);
      }
    }
    return tags;
  }

  const Points3d& V_;
  const Topology& topology_;
  double strong_;
  double diagonal_;
  Points3d normals_;                      // of the triangles, as long as twice their area
  std::vector<double> angle_;             // of the edges, radians
  std::vector<char> candidate_, crease_;  // edges
  std::vector<int32_t> mark_;             // last search that reached a triangle
  int32_t stamp_ = -1;
  std::vector<int32_t> front_;
  std::vector<double> angles_;
};

}  // namespace

CreaseTags DetectCreases(const Points3d& vertices, const Topology& topology, double angle,
                         CreaseEffort effort) {
  if (angle <= 0) return {};
  return Detector(vertices, topology, angle).Run(effort);
}

}  // namespace cagefit
