#include "tests/support/shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

namespace cagefit::testing {

namespace {

constexpr double kPi = 3.14159265358979323846;

// Two triangles for every cell of a grid of `columns` x `rows` vertices, numbered row by row;
// columns and rows may close upon themselves.
Triangles GridTriangles(int columns, int rows, bool close_columns, bool close_rows) {
  const int cells_x = close_columns ? columns : columns - 1, cells_y = close_rows ? rows : rows - 1;
  Triangles triangles(3, 2 * cells_x * cells_y);
  int f = 0;
  for (int j = 0; j < cells_y; ++j) {
    for (int i = 0; i < cells_x; ++i) {
      const int right = (i + 1) % columns, up = (j + 1) % rows;
      const int a = j * columns + i, b = j * columns + right, c = up * columns + right,
                d = up * columns + i;
      triangles.col(f++) << a, b, c;
      triangles.col(f++) << a, c, d;
    }
  }
  return triangles;
}

// The patches in one mesh, vertices at the same position (to 1e-9) merged.
TriangleMesh Weld(const std::vector<TriangleMesh>& patches) {
  std::map<std::array<int64_t, 3>, int32_t> at;
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  for (const TriangleMesh& patch : patches) {
    std::vector<int32_t> index(patch.vertices.cols());
    for (Eigen::Index v = 0; v < patch.vertices.cols(); ++v) {
      const Eigen::Vector3d p = patch.vertices.col(v);
      const std::array<int64_t, 3> key = {std::llround(p.x() * 1e9), std::llround(p.y() * 1e9),
                                          std::llround(p.z() * 1e9)};
      const auto [entry, added] = at.try_emplace(key, static_cast<int32_t>(vertices.size()));
      if (added) vertices.push_back(p);
      index[v] = entry->second;
    }
    for (Eigen::Index f = 0; f < patch.triangles.cols(); ++f) {
      const auto t = patch.triangles.col(f);
      triangles.emplace_back(index[t[0]], index[t[1]], index[t[2]]);
    }
  }
  TriangleMesh mesh;
  mesh.vertices.resize(3, static_cast<Eigen::Index>(vertices.size()));
  for (size_t v = 0; v < vertices.size(); ++v) mesh.vertices.col(v) = vertices[v];
  mesh.triangles.resize(3, static_cast<Eigen::Index>(triangles.size()));
  for (size_t f = 0; f < triangles.size(); ++f) mesh.triangles.col(f) = triangles[f];
  return mesh;
}

TriangleMesh Icosahedron() {
  const double g = (1 + std::sqrt(5.0)) / 2;
  TriangleMesh mesh;
  mesh.vertices.resize(3, 12);
  mesh.vertices << -1, 1, -1, 1, 0, 0, 0, 0, g, g, -g, -g,  // x
      g, g, -g, -g, -1, 1, -1, 1, 0, 0, 0, 0,               // y
      0, 0, 0, 0, g, g, -g, -g, -1, 1, -1, 1;               // z
  mesh.triangles.resize(3, 20);
  mesh.triangles << 0, 0, 0, 0, 0, 1, 5, 11, 10, 7, 3, 3, 3, 3, 3, 4, 2, 6, 8, 9,  // first corners
      11, 5, 1, 7, 10, 5, 11, 10, 7, 1, 9, 4, 2, 6, 8, 9, 4, 2, 6, 8,              // second
      5, 1, 7, 10, 11, 9, 4, 2, 6, 8, 4, 2, 6, 8, 9, 5, 11, 10, 7, 1;              // third
  return mesh;
}

// Splits every triangle in four at its edges' midpoints.
TriangleMesh SplitAtMidpoints(const TriangleMesh& coarse) {
  std::map<std::pair<int, int>, int> middle_of;
  std::vector<Eigen::Vector3d> vertices;
  for (Eigen::Index v = 0; v < coarse.vertices.cols(); ++v) {
    vertices.push_back(coarse.vertices.col(v));
  }
  const auto middle = [&](int a, int b) {
    const auto [at, added] = middle_of.try_emplace(std::minmax(a, b), vertices.size());
    if (added) vertices.push_back((vertices[a] + vertices[b]) / 2);
    return at->second;
  };
  TriangleMesh fine;
  fine.triangles.resize(3, 4 * coarse.triangles.cols());
  for (Eigen::Index f = 0; f < coarse.triangles.cols(); ++f) {
    const int a = coarse.triangles(0, f), b = coarse.triangles(1, f), c = coarse.triangles(2, f);
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.triangles.col(4 * f) << a, ab, ca;
    fine.triangles.col(4 * f + 1) << b, bc, ab;
    fine.triangles.col(4 * f + 2) << c, ca, bc;
    fine.triangles.col(4 * f + 3) << ab, bc, ca;
  }
  fine.vertices.resize(3, static_cast<Eigen::Index>(vertices.size()));
  for (size_t v = 0; v < vertices.size(); ++v) {
    fine.vertices.col(static_cast<Eigen::Index>(v)) = vertices[v];
  }
  return fine;
}

// Corner of triangle f that follows vertex v, or -1 when v is not one of its corners.
int CornerAfter(const Triangles& triangles, Eigen::Index f, int v) {
  for (int c = 0; c < 3; ++c) {
    if (triangles(c, f) == v) return triangles((c + 1) % 3, f);
  }
  return -1;
}

bool Adjacent(const Triangles& triangles, int a, int b) {
  for (Eigen::Index f = 0; f < triangles.cols(); ++f) {
    if (CornerAfter(triangles, f, a) >= 0 && CornerAfter(triangles, f, b) >= 0) return true;
  }
  return false;
}

}  // namespace

TriangleMesh Icosphere(int levels, double radius) {
  TriangleMesh mesh = Icosahedron();
  for (int level = 0; level < levels; ++level) mesh = SplitAtMidpoints(mesh);
  mesh.vertices = radius * mesh.vertices.colwise().normalized();
  return mesh;
}

TriangleMesh OpenGrid(int cells) {
  TriangleMesh mesh;
  mesh.triangles = GridTriangles(cells + 1, cells + 1, false, false);
  mesh.vertices.resize(3, static_cast<Eigen::Index>(cells + 1) * (cells + 1));
  for (int v = 0; v < mesh.vertices.cols(); ++v) {
    mesh.vertices.col(v) << double(v % (cells + 1)) / cells, double(v / (cells + 1)) / cells, 0;
  }
  return mesh;
}

TriangleMesh OpenDisk(int rings, double radius) {
  TriangleMesh mesh;
  mesh.vertices.resize(3, 1 + 3 * rings * (rings + 1));
  mesh.triangles.resize(3, 6 * rings * rings);
  mesh.vertices.col(0).setZero();
  const auto vertex = [](int ring, int k) {
    return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1) + k % (6 * ring);
  };
  int f = 0;
  for (int ring = 1; ring <= rings; ++ring) {
    for (int k = 0; k < 6 * ring; ++k) {
      const double angle = 2 * kPi * k / (6 * ring), r = radius * ring / rings;
      mesh.vertices.col(vertex(ring, k)) << r * std::cos(angle), r * std::sin(angle), 0;
      // The k-th vertex lies in sextant k / ring; going inwards loses one vertex per sextant.
      const int inner = k - k / ring;
      mesh.triangles.col(f++) << vertex(ring, k), vertex(ring, k + 1), vertex(ring - 1, inner);
      if (k % ring != ring - 1) {
        mesh.triangles.col(f++) << vertex(ring, k + 1), vertex(ring - 1, inner + 1),
            vertex(ring - 1, inner);
      }
    }
  }
  return mesh;
}

TriangleMesh Torus(int around, int across, double major_radius, double minor_radius) {
  TriangleMesh mesh;
  mesh.triangles = GridTriangles(around, across, true, true);
  mesh.vertices.resize(3, static_cast<Eigen::Index>(around) * across);
  for (int v = 0; v < mesh.vertices.cols(); ++v) {
    const double a = 2 * kPi * (v % around) / around, b = 2 * kPi * (v / around) / across;
    const double r = major_radius + minor_radius * std::cos(b);
    mesh.vertices.col(v) << r * std::cos(a), r * std::sin(a), minor_radius * std::sin(b);
  }
  return mesh;
}

TriangleMesh Tube(int around, int along, double radius, double length) {
  TriangleMesh mesh;
  mesh.triangles = GridTriangles(around, along + 1, true, false);
  mesh.vertices.resize(3, static_cast<Eigen::Index>(around) * (along + 1));
  for (int v = 0; v < mesh.vertices.cols(); ++v) {
    const double a = 2 * kPi * (v % around) / around;
    mesh.vertices.col(v) << radius * std::cos(a), radius * std::sin(a),
        length * (v / around) / along;
  }
  return mesh;
}

TriangleMesh Bipyramid(int around) {
  TriangleMesh mesh;
  mesh.vertices.resize(3, around + 2);
  mesh.vertices.col(0) << 0, 0, 1;
  mesh.vertices.col(1) << 0, 0, -1;
  mesh.triangles.resize(3, 2 * around);
  for (int k = 0; k < around; ++k) {
    const double angle = 2 * kPi * k / around;
    const int a = 2 + k, b = 2 + (k + 1) % around;
    mesh.vertices.col(a) << std::cos(angle), std::sin(angle), 0.1 * (k % 3);
    mesh.triangles.col(2 * k) << 0, a, b;
    mesh.triangles.col(2 * k + 1) << 1, b, a;
  }
  return mesh;
}

TriangleMesh Cube(int cells) {
  std::vector<TriangleMesh> faces;
  for (int axis = 0; axis < 3; ++axis) {
    TriangleMesh high = OpenGrid(cells);  // in the plane of the other two axes, seen from outside
    const Points3d grid = high.vertices;
    for (int k = 0; k < 3; ++k) high.vertices.row((axis + 1 + k) % 3) = grid.row(k);
    TriangleMesh low = high;
    high.vertices.row(axis).setOnes();
    low.triangles.row(1).swap(low.triangles.row(2));
    faces.push_back(std::move(high));
    faces.push_back(std::move(low));
  }
  return Weld(faces);
}

TriangleMesh Drum(int rings, double radius, double length) {
  TriangleMesh top = OpenDisk(rings, radius), bottom = top;
  top.vertices.row(2).setConstant(length);
  bottom.triangles.row(1).swap(bottom.triangles.row(2));
  return Weld({std::move(top), std::move(bottom), Tube(6 * rings, 2 * rings, radius, length)});
}

TriangleMesh MixedValences(uint32_t seed) {
  TriangleMesh mesh = Icosphere(2);
  Triangles& triangles = mesh.triangles;
  std::mt19937 random(seed);
  std::vector<int> valence(mesh.vertices.cols(), 0);
  for (Eigen::Index k = 0; k < triangles.size(); ++k) ++valence[triangles.data()[k]];
  for (int tries = 0; tries < 2000; ++tries) {
    // Edge a-b of triangles (a b c) and (b a d) becomes c-d.
    const Eigen::Index f = random() % triangles.cols();
    const int corner = static_cast<int>(random() % 3);
    const int a = triangles(corner, f), b = triangles((corner + 1) % 3, f),
              c = triangles((corner + 2) % 3, f);
    Eigen::Index g = 0;
    while (CornerAfter(triangles, g, b) != a) ++g;
    const int d = CornerAfter(triangles, g, a);
    if (valence[a] == 3 || valence[b] == 3 || valence[c] == 12 || valence[d] == 12) continue;
    if (Adjacent(triangles, c, d)) continue;
    triangles.col(f) << a, d, c;
    triangles.col(g) << b, c, d;
    --valence[a], --valence[b], ++valence[c], ++valence[d];
  }
  for (Eigen::Index k = 0; k < mesh.vertices.size(); ++k) {
    mesh.vertices.data()[k] += 0.02 * (random() / 4294967296.0 - 0.5);
  }
  return mesh;
}

namespace {

// Raises the valences of the first vertices of a sphere to `targets` by flips that keep every
// triangle facing outwards and every edge between two of these vertices.
class HubMaker {
 public:
  HubMaker(TriangleMesh mesh, std::vector<int> targets)
      : mesh_(std::move(mesh)), targets_(std::move(targets)), valence_(mesh_.vertices.cols(), 0) {
    for (Eigen::Index k = 0; k < mesh_.triangles.size(); ++k) ++valence_[mesh_.triangles.data()[k]];
  }

  TriangleMesh Make() {
    for (int round = 0; round < 200 && !IsDone(); ++round) {
      for (int tries = 0; tries < 20000; ++tries) TryFlip();
      for (int v = 0; v < mesh_.vertices.cols(); ++v) MoveToMiddle(v);
    }
    return mesh_;
  }

 private:
  bool IsHub(int v) const { return v < static_cast<int>(targets_.size()); }
  bool IsFull(int v) const { return IsHub(v) && valence_[v] >= targets_[v]; }
  bool IsDone() const {
    for (size_t v = 0; v < targets_.size(); ++v) {
      if (valence_[v] != targets_[v]) return false;
    }
    return true;
  }
  bool FacesOutwards(int a, int b, int c) const {
    const Points3d& V = mesh_.vertices;
    return V.col(a).dot(V.col(b).cross(V.col(c))) > 1e-5;
  }

  // Edge a-b of triangles (a b c) and (b a d) becomes c-d where that serves the hub c, or, between
  // ordinary vertices, where it evens out the valences.
  void TryFlip() {
    Triangles& triangles = mesh_.triangles;
    const Eigen::Index f = random_() % triangles.cols();
    const int corner = static_cast<int>(random_() % 3);
    const int a = triangles(corner, f), b = triangles((corner + 1) % 3, f),
              c = triangles((corner + 2) % 3, f);
    if ((IsHub(a) && IsHub(b)) || valence_[a] == 3 || valence_[b] == 3 || IsFull(c)) return;
    Eigen::Index g = 0;
    while (CornerAfter(triangles, g, b) != a) ++g;
    const int d = CornerAfter(triangles, g, a);
    if (IsFull(d)) return;
    const bool helps_hub = (IsHub(c) || IsHub(d)) && !IsHub(a) && !IsHub(b);
    const bool evens = valence_[c] + valence_[d] + 2 < valence_[a] + valence_[b];
    if (IsHub(a) || IsHub(b) || !(helps_hub || evens)) return;
    if (!FacesOutwards(a, d, c) || !FacesOutwards(b, c, d) || Adjacent(triangles, c, d)) return;
    triangles.col(f) << a, d, c;
    triangles.col(g) << b, c, d;
    --valence_[a], --valence_[b], ++valence_[c], ++valence_[d];
  }

  // Of its ring, unless a triangle would turn over.
  void MoveToMiddle(int v) {
    Points3d& V = mesh_.vertices;
    const Eigen::Vector3d old = V.col(v);
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::vector<Eigen::Index> around;
    for (Eigen::Index f = 0; f < mesh_.triangles.cols(); ++f) {
      const int next = CornerAfter(mesh_.triangles, f, v);
      if (next < 0) continue;
      around.push_back(f);
      sum += V.col(next);
    }
    V.col(v) = sum.normalized();
    for (const Eigen::Index f : around) {
      const auto t = mesh_.triangles.col(f);
      if (!FacesOutwards(t(0), t(1), t(2))) V.col(v) = old;
    }
  }

  TriangleMesh mesh_;
  std::vector<int> targets_, valence_;
  std::mt19937 random_{1};
};

}  // namespace

TriangleMesh TouchingHubs() {
  // A strip of triangles: each hub is the other common neighbour of the two before it.
  TriangleMesh mesh = Icosphere(3);
  std::vector<int> order = {mesh.triangles(0, 300), mesh.triangles(1, 300)};
  while (order.size() < 14) {
    const int a = order[order.size() - 2], b = order.back();
    const int before = order.size() > 2 ? order[order.size() - 3] : -1;
    for (Eigen::Index f = 0; f < mesh.triangles.cols(); ++f) {
      const int next = CornerAfter(mesh.triangles, f, b);
      const bool is_beside = next == a || CornerAfter(mesh.triangles, f, a) == b;
      if (!is_beside || next < 0 || CornerAfter(mesh.triangles, f, a) < 0) continue;
      const int third = mesh.triangles.col(f).sum() - a - b;
      if (third == before) continue;
      order.push_back(third);
      break;
    }
  }
  std::vector<int> number(mesh.vertices.cols(), -1);
  for (size_t k = 0; k < order.size(); ++k) number[order[k]] = static_cast<int>(k);
  auto next = static_cast<int>(order.size());
  for (int& k : number) {
    if (k < 0) k = next++;
  }
  Points3d V = mesh.vertices;
  for (Eigen::Index v = 0; v < V.cols(); ++v) mesh.vertices.col(number[v]) = V.col(v);
  for (Eigen::Index k = 0; k < mesh.triangles.size(); ++k) {
    mesh.triangles.data()[k] = number[mesh.triangles.data()[k]];
  }
  std::vector<int> targets;
  for (int k = 0; k < 14; ++k) targets.push_back(7 + (5 * k) % 14);
  return HubMaker(std::move(mesh), targets).Make();
}

TriangleMesh Together(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh both;
  both.vertices.resize(3, a.vertices.cols() + b.vertices.cols());
  both.vertices << a.vertices, b.vertices;
  both.triangles.resize(3, a.triangles.cols() + b.triangles.cols());
  both.triangles << a.triangles, b.triangles.array() + static_cast<int32_t>(a.vertices.cols());
  return both;
}

}  // namespace cagefit::testing
