#include "server/session/flip_counter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <tuple>

namespace cagefit::server {
namespace {

// Pairs of triangles on the two sides of each inner edge, found by sorting the edges.
std::vector<std::array<int32_t, 2>> AdjacentTriangles(const Triangles& triangles) {
  std::vector<std::tuple<int32_t, int32_t, int32_t>> edges;  // smaller vertex, larger, triangle
  edges.reserve(3 * triangles.cols());
  for (int32_t f = 0; f < triangles.cols(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const auto ends = std::minmax(triangles(c, f), triangles((c + 1) % 3, f));
      edges.emplace_back(ends.first, ends.second, f);
    }
  }
  std::sort(edges.begin(), edges.end());
  std::vector<std::array<int32_t, 2>> pairs;
  for (size_t e = 1; e < edges.size(); ++e) {
    const auto& [a, b, f] = edges[e - 1];
    const auto& [c, d, g] = edges[e];
    if (a == c && b == d) pairs.push_back({f, g});
  }
  return pairs;
}

}  // namespace

FlipCounter::FlipCounter(const Triangles& triangles, const Points3d& template_points)
    : triangles_(triangles),
      neighbors_(AdjacentTriangles(triangles)),
      neighbor_count_(triangles.cols(), 0) {
  for (const auto& pair : neighbors_) {
    for (const int32_t f : pair) ++neighbor_count_[f];
  }
  turned_in_template_ = TurnedAgainstNeighbors(template_points);
}

std::vector<char> FlipCounter::TurnedAgainstNeighbors(const Points3d& points) const {
  Points3d normals(3, triangles_.cols());
  for (int64_t f = 0; f < triangles_.cols(); ++f) {
    const auto a = points.col(triangles_(0, f));
    normals.col(f) = (points.col(triangles_(1, f)) - a).cross(points.col(triangles_(2, f)) - a);
  }
  std::vector<int32_t> against(triangles_.cols(), 0);
  for (const auto& [f, g] : neighbors_) {
    if (normals.col(f).dot(normals.col(g)) >= 0) continue;
    ++against[f];
    ++against[g];
  }
  std::vector<char> turned(triangles_.cols());
  for (size_t f = 0; f < turned.size(); ++f) turned[f] = 2 * against[f] > neighbor_count_[f];
  return turned;
}

double FlipCounter::Share(const Points3d& points) const {
  const std::vector<char> turned = TurnedAgainstNeighbors(points);
  int64_t flipped = 0;
  for (size_t f = 0; f < turned.size(); ++f) flipped += turned[f] && !turned_in_template_[f];
  return turned.empty() ? 0 : static_cast<double>(flipped) / static_cast<double>(turned.size());
}

}  // namespace cagefit::server
