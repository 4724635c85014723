#include "core/mesh/triangle_bvh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

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

}  // namespace

ClosestPoint ClosestPointOnTriangle(const Eigen::Vector3d& x, const Eigen::Vector3d& a,
                                    const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  ClosestPoint out;
  out.triangle = 0;
  const auto finish = [&](double u, double v) {
    out.u = u;
    out.v = v;
    out.point = a + u * (b - a) + v * (c - a);
    out.distance = (x - out.point).norm();
    return out;
  };
  const Eigen::Vector3d ab = b - a, ac = c - a, ax = x - a;
  const double d1 = ab.dot(ax), d2 = ac.dot(ax);
  if (d1 <= 0 && d2 <= 0) return finish(0, 0);
  const Eigen::Vector3d bx = x - b;
  const double d3 = ab.dot(bx), d4 = ac.dot(bx);
  if (d3 >= 0 && d4 <= d3) return finish(1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return finish(d1 - d3 > 0 ? d1 / (d1 - d3) : 0, 0);
  const Eigen::Vector3d cx = x - c;
  const double d5 = ab.dot(cx), d6 = ac.dot(cx);
  if (d6 >= 0 && d5 <= d6) return finish(0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return finish(0, d2 - d6 > 0 ? d2 / (d2 - d6) : 0);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double length = (d4 - d3) + (d5 - d6);
    const double w = length > 0 ? (d4 - d3) / length : 0;
    return finish(1 - w, w);
  }
  const double inverse = 1 / (va + vb + vc);
  return finish(vb * inverse, vc * inverse);
}

void TriangleBvh::Build(const Points3d& vertices, const Triangles& triangles) {
  const int32_t count = static_cast<int32_t>(triangles.cols());
  nodes_.clear();
  order_.resize(count);
  corners_.resize(3, 3 * static_cast<int64_t>(count));
  if (count == 0) return;
  std::iota(order_.begin(), order_.end(), 0);
  Points3f centers(3, count);
  for (int32_t f = 0; f < count; ++f) {
    centers.col(f) = ((vertices.col(triangles(0, f)) + vertices.col(triangles(1, f)) +
                       vertices.col(triangles(2, f))) /
                      3)
                         .cast<float>();
  }
  nodes_.reserve(2 * (count / kLeafSize) + 2);
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
    Eigen::Vector3f low = centers.col(order_[range.begin]), high = low;
    for (int32_t k = range.begin; k < range.end; ++k) {
      low = low.cwiseMin(centers.col(order_[k]));
      high = high.cwiseMax(centers.col(order_[k]));
    }
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const int32_t middle = (range.begin + range.end) / 2;
    std::nth_element(order_.begin() + range.begin, order_.begin() + middle,
                     order_.begin() + range.end, [&](int32_t a, int32_t b) {
                       const float ca = centers(axis, a), cb = centers(axis, b);
                       return ca != cb ? ca < cb : a < b;
                     });
    const int32_t left = static_cast<int32_t>(nodes_.size());
    nodes_.resize(left + 2);
    nodes_[range.node].begin = left;
    stack.push_back({left, range.begin, middle});
    stack.push_back({left + 1, middle, range.end});
  }
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

ClosestPoint TriangleBvh::Closest(const Eigen::Vector3d& x, double max_distance) const {
  ClosestPoint best;
  best.distance = max_distance;
  if (order_.empty()) return best;
  double best_squared = max_distance * max_distance;
  std::array<std::pair<double, int32_t>, kMaxDepth> stack;
  int depth = 0;
  stack[depth++] = {SquaredDistanceToBox(x, nodes_[0].min, nodes_[0].max), 0};
  while (depth > 0) {
    const auto [squared, index] = stack[--depth];
    if (squared > best_squared) continue;
    const Node& node = nodes_[index];
    if (node.count == 0) {
      const int32_t left = node.begin, right = left + 1;
      const double to_left = SquaredDistanceToBox(x, nodes_[left].min, nodes_[left].max);
      const double to_right = SquaredDistanceToBox(x, nodes_[right].min, nodes_[right].max);
      if (to_left <= to_right) {
        stack[depth++] = {to_right, right};
        stack[depth++] = {to_left, left};
      } else {
        stack[depth++] = {to_left, left};
        stack[depth++] = {to_right, right};
      }
      continue;
    }
    for (int32_t k = node.begin; k < node.begin + node.count; ++k) {
      ClosestPoint candidate = ClosestPointOnTriangle(
          x, corners_.col(3 * k), corners_.col(3 * k + 1), corners_.col(3 * k + 2));
      candidate.triangle = order_[k];
      const bool nearer =
          candidate.distance < best.distance ||
          (candidate.distance == best.distance && candidate.triangle < best.triangle);
      if (nearer) {
        best = candidate;
        best_squared = best.distance * best.distance;
      }
    }
  }
  if (best.triangle < 0) best.distance = std::numeric_limits<double>::infinity();
  return best;
}

}  // namespace cagefit
