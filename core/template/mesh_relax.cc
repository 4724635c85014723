#include "core/template/mesh_relax.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh/topology.h"

namespace cagefit {

namespace {

// A flip may bend the surface by so much: cosine between the normals of the two triangles, before
// and after.
constexpr double kLeastFlipCosine = 0.9;
constexpr double kLeastNeedleFlipCosine = 0.8;  // to the two triangles' mean normal
constexpr double kPoorAngle = 0.2, kThinAngle = 0.35, kGoodAngle = 0.5;  // radians
constexpr double kWorthwhile =
    1.5;  // times the smallest angle, for the sake of which valences suffer
constexpr int kMostValence = 9;
constexpr double kStep = 0.5;  // of the way to the middle of the ring

Eigen::Vector3d Cross(const Points3d& V, int32_t a, int32_t b, int32_t c) {
  return (V.col(b) - V.col(a)).cross(V.col(c) - V.col(a));
}

double SmallestAngle(const Points3d& V, int32_t a, int32_t b, int32_t c) {
  const int32_t t[3] = {a, b, c};
  double smallest = 4;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d u = V.col(t[(k + 1) % 3]) - V.col(t[k]);
    const Eigen::Vector3d w = V.col(t[(k + 2) % 3]) - V.col(t[k]);
    smallest = std::min(smallest, std::atan2(u.cross(w).norm(), u.dot(w)));
  }
  return smallest;
}

//      c                c
//    / | \            /   \        Edge (a b) between triangles (a b c) and (b a d) becomes (c d):
//   a--|--b   from   a --- b       triangles (a d c) and (d b c).
//    \ | /            \   /
//      d                d
bool IsBetterFlipped(const Points3d& V, const Topology& topology, const std::vector<int>& valence,
                     int32_t a, int32_t b, int32_t c, int32_t d) {
  if (topology.FindEdge(c, d) != Topology::kNone) return false;
  const auto excess = [&](int32_t v, int change) {
    const int ideal = topology.IsBoundaryVertex(v) ? 4 : 6;
    return (valence[v] + change - ideal) * (valence[v] + change - ideal);
  };
  for (const int32_t v : {a, b}) {
    if (valence[v] <= (topology.IsBoundaryVertex(v) ? 2 : 3)) return false;
  }
  const double old_angle = std::min(SmallestAngle(V, a, b, c), SmallestAngle(V, b, a, d));
  const double new_angle = std::min(SmallestAngle(V, a, d, c), SmallestAngle(V, d, b, c));
  const Eigen::Vector3d old_1 = Cross(V, a, b, c), old_2 = Cross(V, b, a, d);
  const Eigen::Vector3d new_1 = Cross(V, a, d, c), new_2 = Cross(V, d, b, c);
  const auto cosine = [](const Eigen::Vector3d& n, const Eigen::Vector3d& m) {
    return n.dot(m) / std::max(n.norm() * m.norm(), 1e-300);
  };
  if (old_angle < kPoorAngle && new_angle > kWorthwhile * old_angle &&
      std::max(valence[c], valence[d]) < kMostValence) {
    // The normal of a needle says little; that of both triangles is their quadrilateral's.
    const double least = std::min(cosine(new_1, old_1 + old_2), cosine(new_2, old_1 + old_2));
    return least > kLeastNeedleFlipCosine;
  }
  const int before = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0);
  const int after = excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1);
  if (after >= before || !(new_angle > 0.6 * old_angle)) return false;
  if (new_angle < kPoorAngle && new_angle < old_angle) return false;
  for (const Eigen::Vector3d* n : {&new_1, &new_2}) {
    if (!(cosine(*n, old_1) > kLeastFlipCosine && cosine(*n, old_2) > kLeastFlipCosine)) {
      return false;
    }
  }
  return true;
}

// One pass over all edges; triangles that a flip touched rest until the next pass.
int FlipEdges(const CreaseTags& tags, TriangleMesh* mesh) {
  const absl::StatusOr<Topology> topology =
      Topology::Create(static_cast<int32_t>(mesh->vertices.cols()), mesh->triangles);
  if (!topology.ok()) return 0;
  std::vector<int> valence(topology->vertex_count());
  for (int32_t v = 0; v < topology->vertex_count(); ++v) valence[v] = topology->Valence(v);
  std::vector<char> touched(topology->vertex_count(), 0), crease(topology->edge_count(), 0);
  for (const auto& [a, b] : tags.edges) crease[topology->FindEdge(a, b)] = 1;
  int flips = 0;
  for (int32_t h = 0; h < 3 * topology->triangle_count(); ++h) {
    const int32_t g = topology->opposite(h);
    if (g == Topology::kNone || g < h || crease[topology->triangle_edge(h / 3, h % 3)]) continue;
    const auto at = [&](int32_t half_edge, int k) {
      return topology->triangles()((half_edge + k) % 3, half_edge / 3);
    };
    const int32_t a = at(h, 0), b = at(h, 1), c = at(h, 2), d = at(g, 2);
    if (touched[a] || touched[b] || touched[c] || touched[d]) continue;
    if (!IsBetterFlipped(mesh->vertices, *topology, valence, a, b, c, d)) continue;
    mesh->triangles.col(h / 3) << a, d, c;
    mesh->triangles.col(g / 3) << d, b, c;
    for (const int32_t v : {a, b, c, d}) touched[v] = 1;
    ++flips;
  }
  return flips;
}

// Smallest angles around v where it is and where it would go.
struct RingAngles {
  double before = 4, after = 4;
  bool turned = false;  // a triangle would turn over
};

RingAngles AnglesAround(const Points3d& V, const Topology& topology, int32_t v,
                        const Eigen::Vector3d& to) {
  const absl::Span<const int32_t> ring = topology.Ring(v);
  Points3d corners(3, 4);  // v, where it goes, and two of its ring
  corners.col(0) = V.col(v);
  corners.col(1) = to;
  RingAngles angles;
  for (size_t k = topology.IsBoundaryVertex(v) ? 1 : 0; k < ring.size(); ++k) {
    corners.col(2) = V.col(ring[(k + ring.size() - 1) % ring.size()]);
    corners.col(3) = V.col(ring[k]);
    const Eigen::Vector3d n = Cross(corners, 0, 2, 3), m = Cross(corners, 1, 2, 3);
    angles.turned = angles.turned || !(m.dot(n) > 0.5 * m.norm() * n.norm());
    angles.before = std::min(angles.before, SmallestAngle(corners, 0, 2, 3));
    angles.after = std::min(angles.after, SmallestAngle(corners, 1, 2, 3));
  }
  return angles;
}

// Neighbours of a vertex along boundaries and creases; more than two do not count.
struct CurveNeighbors {
  int count = 0;
  int32_t ends[2] = {-1, -1};
  void Add(int32_t v) {
    if (count < 2) ends[count] = v;
    ++count;
  }
};

std::vector<CurveNeighbors> FindCurves(const Topology& topology, const CreaseTags& tags) {
  std::vector<CurveNeighbors> curves(topology.vertex_count());
  const auto add = [&](int32_t a, int32_t b) {
    curves[a].Add(b);
    curves[b].Add(a);
  };
  for (const auto& [a, b] : tags.edges) {
    if (!topology.IsBoundaryEdge(topology.FindEdge(a, b))) add(a, b);
  }
  for (int32_t e = 0; e < topology.edge_count(); ++e) {
    if (topology.IsBoundaryEdge(e)) add(topology.edge(e)[0], topology.edge(e)[1]);
  }
  return curves;
}

class Slider {
 public:
  Slider(const FineSurface& surface, const Topology& topology, TriangleMesh* mesh)
      : surface_(surface),
        topology_(topology),
        normals_(VertexNormals(*mesh)),
        V_(mesh->vertices) {}

  // No triangle may turn over, and none gets a smaller angle than the ring's smallest unless it
  // keeps kGoodAngle.
  void AlongSurface(int32_t v) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    double ring_length = 0;
    for (const int32_t n : topology_.Ring(v)) {
      middle += V_.col(n);
      ring_length = std::max(ring_length, (V_.col(n) - V_.col(v)).norm());
    }
    middle /= topology_.Valence(v);
    Eigen::Vector3d move = kStep * (middle - V_.col(v));
    move -= normals_.col(v).dot(move) * normals_.col(v);
    const auto to = surface_.Nearest(V_.col(v) + move, ring_length);
    if (!to.has_value()) return;
    const RingAngles angles = AnglesAround(V_, topology_, v, *to);
    if (!angles.turned && angles.after >= std::min(angles.before, kGoodAngle)) V_.col(v) = *to;
  }

  void AlongCurve(int32_t v, const CurveNeighbors& curve) {
    const Eigen::Vector3d a = V_.col(curve.ends[0]), b = V_.col(curve.ends[1]);
    const Eigen::Vector3d move = kStep * (0.5 * (a + b) - V_.col(v));
    const auto to = surface_.NearestOnCurve(V_.col(v) + move, b - a, (b - a).norm());
    if (!to.has_value()) return;
    const RingAngles angles = AnglesAround(V_, topology_, v, *to);
    if (!angles.turned && angles.before < kThinAngle && angles.after > angles.before) {
      V_.col(v) = *to;
    }
  }

 private:
  const FineSurface& surface_;
  const Topology& topology_;
  const Points3d normals_;
  Points3d& V_;
};

void SlideVertices(const FineSurface& surface, const CreaseTags& tags, TriangleMesh* mesh) {
  const absl::StatusOr<Topology> topology =
      Topology::Create(static_cast<int32_t>(mesh->vertices.cols()), mesh->triangles);
  if (!topology.ok()) return;
  const std::vector<CurveNeighbors> curves = FindCurves(*topology, tags);
  std::vector<char> corner(topology->vertex_count(), 0);
  for (const int32_t v : tags.corners) corner[v] = 1;
  Slider slider(surface, *topology, mesh);
  for (int32_t v = 0; v < topology->vertex_count(); ++v) {
    if (corner[v]) continue;
    if (curves[v].count == 0) slider.AlongSurface(v);
    if (curves[v].count == 2) slider.AlongCurve(v, curves[v]);
  }
}

}  // namespace

void RelaxMesh(const FineSurface& surface, int rounds, TaggedMesh* tagged) {
  for (int round = 0; round < rounds; ++round) {
    while (FlipEdges(tagged->tags, &tagged->mesh) > tagged->mesh.triangles.cols() / 200) {
    }
    SlideVertices(surface, tagged->tags, &tagged->mesh);
  }
}

}  // namespace cagefit
