#include "core/mesh/triangle_bvh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace cagefit {

namespace {

constexpr int32_t kLeafSize = 4;
constexpr int kMaxDepth = 64;  // median splits halve, so 2^31 triangles need 31

// Outward rounding of a double bound to float.
Eigen::Vector3f Below(const Eigen::Vector3d& x) {
  return x.cast<float>().unaryExpr([](float v) { return std::nextafter(v, -INFINITY); });
}
Eigen::Vector3f Above(const Eigen::Vector3d& x) {
  return x.cast<float>().unaryExpr([](float v) { return std::nextafter(v, INFINITY); });
}

double SquaredDistanceToBox(const Eigen::Vector3d& x, const Eigen::Vector3f& min,
                            const Eigen::Vector3f& max) {
  const Eigen::Array3d below = min.cast<double>().array() - x.array();
  const Eigen::Array3d above = x.array() - max.cast<double>().array();
  return below.max(above).max(0.0).square().sum();
}

// A point of a triangle at barycentric (1 - u - v, u, v).
struct Candidate {
  double u = 0, v = 0;
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double squared_distance = std::numeric_limits<double>::infinity();
};

Candidate At(const Eigen::Vector3d& x, const Eigen::Vector3d& a, const Eigen::Vector3d& ab,
             const Eigen::Vector3d& ac, double u, double v) {
  const Eigen::Vector3d point = a + u * ab + v * ac;
  return {u, v, point, (x - point).squaredNorm()};
}

// Fraction 0..1 of the way along `edge` at which `along` lies; both are scalar products with it.
double Fraction(double along, double squared_length) {
  return squared_length > 0 ? std::clamp(along / squared_length, 0.0, 1.0) : 0;
}

// The three edges as segments: for triangles without area.
Candidate ClosestOnEdges(const Eigen::Vector3d& x, const Eigen::Vector3d& a,
                         const Eigen::Vector3d& ab, const Eigen::Vector3d& ac) {
  const Eigen::Vector3d bc = ac - ab, ax = x - a;
  Candidate best = At(x, a, ab, ac, Fraction(ab.dot(ax), ab.squaredNorm()), 0);
  const Candidate on_ac = At(x, a, ab, ac, 0, Fraction(ac.dot(ax), ac.squaredNorm()));
  if (on_ac.squared_distance < best.squared_distance) best = on_ac;
  const double w = Fraction(bc.dot(ax - ab), bc.squaredNorm());
  const Candidate on_bc = At(x, a, ab, ac, 1 - w, w);
  return on_bc.squared_distance < best.squared_distance ? on_bc : best;
}

// [ericson2005, 5.1.5]
Candidate ClosestOnTriangle(const Eigen::Vector3d& x, const Eigen::Vector3d& a,
                            const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, ax = x - a;
  // Below this share of |ab|^2 |ac|^2 the squared area is rounding error, and the signs that tell
  // the regions apart mean nothing.
  if (!(ab.cross(ac).squaredNorm() > 1e-16 * ab.squaredNorm() * ac.squaredNorm())) {
    return ClosestOnEdges(x, a, ab, ac);
  }
  const auto at = [&](double u, double v) { return At(x, a, ab, ac, u, v); };
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0 && d2 <= 0) return at(0, 0);
  const Eigen::Vector3d bx = x - b;
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0 && d4 <= d3) return at(1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return at(Fraction(d1, d1 - d3), 0);
  const Eigen::Vector3d cx = x - c;
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0 && d5 <= d6) return at(0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return at(0, Fraction(d2, d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) {
    const double w = Fraction(d4 - d3, (d4 - d3) + (d5 - d6));
    return at(1 - w, w);
  }
  const double sum = va + vb + vc;
  return at(vb / sum, vc / sum);
}

ClosestPoint ToClosestPoint(const Candidate& candidate, int32_t triangle) {
  return {triangle, candidate.u, candidate.v, std::sqrt(candidate.squared_distance),
          candidate.point};
}

}  // namespace

ClosestPoint ClosestPointOnTriangle(const Eigen::Vector3d& x, const Eigen::Vector3d& a,
                                    const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return ToClosestPoint(ClosestOnTriangle(x, a, b, c), 0);
}

void TriangleBvh::Build(const Points3d& vertices, const Triangles& triangles) {
  const int32_t count = static_cast<int32_t>(triangles.cols());
  nodes_.clear();
  order_.resize(count);
  corners_.resize(3, 3 * static_cast<int64_t>(count));
  if (count == 0) return;
  Split(vertices, triangles);
  for (int32_t k = 0; k < count; ++k) {
    for (int c = 0; c < 3; ++c) corners_.col(3 * k + c) = vertices.col(triangles(c, order_[k]));
  }
  // Children follow their parents, so going backwards meets them first.
  for (int32_t i = static_cast<int32_t>(nodes_.size()) - 1; i >= 0; --i) {
    Node& node = nodes_[i];
    if (node.count > 0) {
      const auto corners = corners_.middleCols(3 * node.begin, 3 * node.count);
      node.min = Below(corners.rowwise().minCoeff());
      node.max = Above(corners.rowwise().maxCoeff());
    } else {
      node.min = nodes_[node.begin].min.cwiseMin(nodes_[node.begin + 1].min);
      node.max = nodes_[node.begin].max.cwiseMax(nodes_[node.begin + 1].max);
    }
  }
}

// Halves ranges of triangles at the median of their centroids along the longest side of these.
void TriangleBvh::Split(const Points3d& vertices, const Triangles& triangles) {
  const int32_t count = static_cast<int32_t>(triangles.cols());
  struct Center {
    Eigen::Vector3f at;
    int32_t triangle;
  };
  std::vector<Center> centers(count);
  for (int32_t f = 0; f < count; ++f) {
    const Eigen::Vector3d sum = vertices.col(triangles(0, f)) + vertices.col(triangles(1, f)) +
                                vertices.col(triangles(2, f));
    centers[f] = {(sum / 3).cast<float>(), f};
  }
  nodes_.reserve(2 * static_cast<size_t>(count / kLeafSize) + 2);
  nodes_.emplace_back();
  struct Range {
    int32_t node, begin, end;
  };
  std::vector<Range> stack = {{0, 0, count}};
  while (!stack.empty()) {
    const Range range = stack.back();
    stack.pop_back();
    if (range.end - range.begin <= kLeafSize) {
      nodes_[range.node].begin = range.begin;
      nodes_[range.node].count = range.end - range.begin;
      continue;
    }
    Eigen::Vector3f low = centers[range.begin].at, high = low;
    for (int32_t k = range.begin; k < range.end; ++k) {
      low = low.cwiseMin(centers[k].at);
      high = high.cwiseMax(centers[k].at);
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const int32_t middle = (range.begin + range.end) / 2;
    std::nth_element(centers.begin() + range.begin, centers.begin() + middle,
                     centers.begin() + range.end, [axis](const Center& a, const Center& b) {
                       return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis]
                                                       : a.triangle < b.triangle;
                     });
    const int32_t left = static_cast<int32_t>(nodes_.size());
    nodes_.resize(left + 2);
    nodes_[range.node].begin = left;
    stack.push_back({left, range.begin, middle});
    stack.push_back({left + 1, middle, range.end});
  }
  for (int32_t k = 0; k < count; ++k) order_[k] = centers[k].triangle;
}

ClosestPoint TriangleBvh::Closest(const Eigen::Vector3d& x, double max_distance) const {
  if (order_.empty()) return {};
  Candidate best;
  best.squared_distance = max_distance * max_distance;
  int32_t triangle = -1;
  // Of two children the nearer goes on top.
  std::array<std::pair<double, int32_t>, kMaxDepth> stack;
  int depth = 0;
  stack[depth++] = {SquaredDistanceToBox(x, nodes_[0].min, nodes_[0].max), 0};
  while (depth > 0) {
    const auto [squared, index] = stack[--depth];
    if (squared > best.squared_distance) continue;
    const Node& node = nodes_[index];
    if (node.count == 0) {
      const int32_t left = node.begin, right = left + 1;
      const double to_left = SquaredDistanceToBox(x, nodes_[left].min, nodes_[left].max);
      const double to_right = SquaredDistanceToBox(x, nodes_[right].min, nodes_[right].max);
      const bool left_first = to_left <= to_right;
      stack[depth++] = left_first ? std::make_pair(to_right, right) : std::make_pair(to_left, left);
      stack[depth++] = left_first ? std::make_pair(to_left, left) : std::make_pair(to_right, right);
      continue;
    }
    for (int32_t k = node.begin; k < node.begin + node.count; ++k) {
      const Candidate candidate = ClosestOnTriangle(x, corners_.col(3 * k), corners_.col(3 * k + 1),
                                                    corners_.col(3 * k + 2));
      if (candidate.squared_distance < best.squared_distance ||
          (candidate.squared_distance == best.squared_distance && order_[k] < triangle)) {
        best = candidate;
        triangle = order_[k];
      }
    }
  }
  return triangle < 0 ? ClosestPoint{} : ToClosestPoint(best, triangle);
}

}  // namespace cagefit
