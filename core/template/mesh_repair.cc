#include "core/template/mesh_repair.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "core/mesh/topology.h"
#include "core/mesh/triangle_quality.h"

namespace cagefit {

namespace {

// Half-edges by the vertex that they start at: chains of a few each.
class HalfEdges {
 public:
  HalfEdges(int64_t vertices, int64_t triangles) : first_(vertices, -1) {
    to_.reserve(3 * triangles);
    next_.reserve(3 * triangles);
  }

  // Numbered in the order in which they were added.
  void Add(int32_t from, int32_t to) {
    next_.push_back(first_[from]);
    first_[from] = static_cast<int32_t>(to_.size());
    to_.push_back(to);
  }
  // -1: there is none.
  int32_t Find(int32_t from, int32_t to) const {
    int32_t h = first_[from];
    while (h >= 0 && to_[h] != to) h = next_[h];
    return h;
  }

 private:
  std::vector<int32_t> first_, next_, to_;
};

double Area(const Points3d& V, const Eigen::Vector3i& t) {
  return 0.5 * (V.col(t[1]) - V.col(t[0])).cross(V.col(t[2]) - V.col(t[0])).norm();
}

// Index of the first vertex at the same position, for every vertex.
std::vector<int32_t> FirstAtPosition(const Points3d& V) {
  std::vector<int32_t> order(V.cols()), first(V.cols());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](int32_t v) { return std::make_tuple(V(0, v), V(1, v), V(2, v)); };
  std::sort(order.begin(), order.end(), [&](int32_t a, int32_t b) {
    return std::make_pair(key(a), a) < std::make_pair(key(b), b);
  });
  for (size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && key(order[k]) == key(order[k - 1]);
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  return first;
}

class UnionFind {
 public:
  explicit UnionFind(int64_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int32_t Find(int32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void Join(int32_t a, int32_t b) { parent_[Find(b)] = Find(a); }

 private:
  std::vector<int32_t> parent_;
};

// Triangles (of merged vertices) that form an edge-manifold, consistently oriented mesh. Half-edge
// 3 f + c of *half_edges starts at corner c of triangle f.
std::vector<Eigen::Vector3i> EdgeManifoldTriangles(const TriangleMesh& mesh,
                                                   HalfEdges* half_edges) {
  const std::vector<int32_t> first = FirstAtPosition(mesh.vertices);
  std::vector<Eigen::Vector3i> triangles;
  triangles.reserve(mesh.triangles.cols());
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    const Eigen::Vector3i t(first[mesh.triangles(0, f)], first[mesh.triangles(1, f)],
                            first[mesh.triangles(2, f)]);
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    if (!(Area(mesh.vertices, t) > 0)) continue;
    bool free = true;
    for (int c = 0; c < 3; ++c) free = free && half_edges->Find(t[c], t[(c + 1) % 3]) < 0;
    if (!free) continue;
    for (int c = 0; c < 3; ++c) half_edges->Add(t[c], t[(c + 1) % 3]);
    triangles.push_back(t);
  }
  return triangles;
}

constexpr int kCapPasses = 10;
constexpr double kCapQuality = 0.15, kCapHeight = 1e-3;  // the latter in diagonals
constexpr double kSameWay = 0.94;                        // cosine of 20 degrees

double Quality(const Points3d& V, const Eigen::Vector3i& t) {
  return TriangleQuality(V.col(t[0]), V.col(t[1]), V.col(t[2]));
}

// Half-edge of the longest side.
int32_t LongestSide(const Points3d& V, const Topology& topology, int32_t f) {
  const auto t = topology.triangles().col(f);
  int longest = 0;
  for (int c = 1; c < 3; ++c) {
    const auto length = [&](int k) { return (V.col(t[(k + 1) % 3]) - V.col(t[k])).squaredNorm(); };
    if (length(c) > length(longest)) longest = c;
  }
  return 3 * f + longest;
}

// Flips half-edge h = (a b) of the cap (a b c), with d across. Returns whether it did.
bool FlipCap(const Topology& topology, int32_t h, double most_height, std::vector<char>* touched,
             TriangleMesh* mesh) {
  const Points3d& V = mesh->vertices;
  const int32_t g = topology.opposite(h);
  if (g == Topology::kNone) return false;
  const auto at = [&](int32_t half_edge, int k) {
    return topology.triangles()((half_edge + k) % 3, half_edge / 3);
  };
  const int32_t a = at(h, 0), b = at(h, 1), c = at(h, 2), d = at(g, 2);
  for (const int32_t v : {a, b, c, d}) {
    if ((*touched)[v]) return false;
  }
  const Eigen::Vector3i cap(a, b, c), across(b, a, d), first(a, d, c), second(d, b, c);
  if (2 * Area(V, cap) > most_height * (V.col(b) - V.col(a)).norm()) return false;
  for (const int32_t v : {a, b}) {
    if (topology.Valence(v) <= (topology.IsBoundaryVertex(v) ? 2 : 3)) return false;
  }
  if (topology.FindEdge(c, d) != Topology::kNone) return false;
  if (!(std::min(Quality(V, first), Quality(V, second)) >
        std::min(Quality(V, cap), Quality(V, across)))) {
    return false;
  }
  const auto cross = [&](const Eigen::Vector3i& t) -> Eigen::Vector3d {
    return (V.col(t[1]) - V.col(t[0])).cross(V.col(t[2]) - V.col(t[0]));
  };
  const Eigen::Vector3d old = cross(across);
  for (const Eigen::Vector3d& n : {cross(first), cross(second)}) {
    if (!(n.dot(old) >= kSameWay * n.norm() * old.norm())) return false;
  }
  mesh->triangles.col(h / 3) = first;
  mesh->triangles.col(g / 3) = second;
  for (const int32_t v : {a, b, c, d}) (*touched)[v] = 1;
  return true;
}

}  // namespace

void FlipCaps(TriangleMesh* mesh) {
  const double most_height = kCapHeight * BoundingBox(mesh->vertices).diagonal();
  for (int pass = 0; pass < kCapPasses; ++pass) {
    const auto topology =
        Topology::Create(static_cast<int32_t>(mesh->vertices.cols()), mesh->triangles);
    if (!topology.ok()) return;
    std::vector<char> touched(mesh->vertices.cols(), 0);
    bool any = false;
    for (int32_t f = 0; f < topology->triangle_count(); ++f) {
      if (Quality(mesh->vertices, topology->triangles().col(f)) >= kCapQuality) continue;
      const int32_t h = LongestSide(mesh->vertices, *topology, f);
      any = FlipCap(*topology, h, most_height, &touched, mesh) || any;
    }
    if (!any) return;
  }
}

TriangleMesh MakeManifold(const TriangleMesh& mesh, RepairReport* report) {
  HalfEdges half_edges(mesh.vertices.cols(), mesh.triangles.cols());
  const std::vector<Eigen::Vector3i> triangles = EdgeManifoldTriangles(mesh, &half_edges);
  report->dropped_triangles += mesh.triangles.cols() - static_cast<int64_t>(triangles.size());
  // Corners of one vertex belong together when an edge at that vertex joins their triangles.
  UnionFind corners(3 * static_cast<int64_t>(triangles.size()));
  for (int32_t h = 0; h < 3 * static_cast<int32_t>(triangles.size()); ++h) {
    const Eigen::Vector3i& t = triangles[h / 3];
    const int32_t g = half_edges.Find(t[(h + 1) % 3], t[h % 3]);
    if (g < 0) continue;
    corners.Join(h, g - g % 3 + (g + 1) % 3);
    corners.Join(h - h % 3 + (h + 1) % 3, g);
  }
  TriangleMesh out;
  out.vertices.resize(3, 3 * static_cast<int64_t>(triangles.size()));
  out.triangles.resize(3, static_cast<int64_t>(triangles.size()));
  std::vector<int32_t> vertex_of_corner(3 * triangles.size(), -1);
  std::vector<char> seen(mesh.vertices.cols(), 0);
  int32_t count = 0;
  for (int32_t corner = 0; corner < static_cast<int32_t>(3 * triangles.size()); ++corner) {
    int32_t& vertex = vertex_of_corner[corners.Find(corner)];
    const int32_t source = triangles[corner / 3][corner % 3];
    if (vertex < 0) {
      vertex = count++;
      out.vertices.col(vertex) = mesh.vertices.col(source);
      report->split_vertices += seen[source];
      seen[source] = 1;
    }
    out.triangles(corner % 3, corner / 3) = vertex;
  }
  out.vertices.conservativeResize(3, count);
  return out;
}

TriangleMesh SelectTriangles(const TriangleMesh& mesh, const std::vector<char>& keep) {
  std::vector<int32_t> index(mesh.vertices.cols(), -1);
  TriangleMesh out;
  out.vertices.resize(3, mesh.vertices.cols());
  out.triangles.resize(3, mesh.triangles.cols());
  int32_t vertices = 0;
  int64_t triangles = 0;
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    if (!keep[f]) continue;
    for (int c = 0; c < 3; ++c) {
      const int32_t v = mesh.triangles(c, f);
      if (index[v] < 0) {
        index[v] = vertices;
        out.vertices.col(vertices++) = mesh.vertices.col(v);
      }
      out.triangles(c, triangles) = index[v];
    }
    ++triangles;
  }
  out.vertices.conservativeResize(3, vertices);
  out.triangles.conservativeResize(3, triangles);
  return out;
}

TriangleMesh KeepLargeComponents(const TriangleMesh& mesh, double share, int* kept, int* dropped) {
  UnionFind parts(mesh.vertices.cols());
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    parts.Join(mesh.triangles(0, f), mesh.triangles(1, f));
    parts.Join(mesh.triangles(0, f), mesh.triangles(2, f));
  }
  std::unordered_map<int32_t, double> area;
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    area[parts.Find(mesh.triangles(0, f))] += Area(mesh.vertices, mesh.triangles.col(f));
  }
  double largest = 0;
  for (const auto& [part, a] : area) largest = std::max(largest, a);
  *kept = static_cast<int>(std::count_if(
      area.begin(), area.end(), [&](const auto& part) { return part.second >= share * largest; }));
  *dropped = static_cast<int>(area.size()) - *kept;
  if (*dropped == 0) return mesh;
  std::vector<char> keep(mesh.triangles.cols());
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    keep[f] = area[parts.Find(mesh.triangles(0, f))] >= share * largest;
  }
  return SelectTriangles(mesh, keep);
}

}  // namespace cagefit
