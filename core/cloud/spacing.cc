#include "core/cloud/spacing.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace cagefit {

namespace {

constexpr int kNeighbors = 7;  // the point itself included
constexpr int64_t kPoints = 2000;

}  // namespace

double MedianSpacing(const Points3f& points, const KdTree& tree) {
  std::vector<float> distances;
  const int64_t stride = std::max<int64_t>(1, points.cols() / kPoints);
  for (int64_t i = 0; i < points.cols(); i += stride) {
    int32_t indices[kNeighbors];
    float squared[kNeighbors];
    const int found = tree.Nearest(points.col(i), kNeighbors, indices, squared);
    distances.push_back(std::sqrt(squared[found - 1]));
  }
  const auto middle = distances.begin() + static_cast<int64_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

}  // namespace cagefit
