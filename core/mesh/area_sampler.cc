#include "core/mesh/area_sampler.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cagefit {

AreaSampler::AreaSampler(const Points3d& vertices, const Triangles& triangles)
    : cumulative_(triangles.cols()) {
  double sum = 0;
  for (int64_t f = 0; f < triangles.cols(); ++f) {
    const Eigen::Vector3d a = vertices.col(triangles(0, f));
    sum += (vertices.col(triangles(1, f)) - a).cross(vertices.col(triangles(2, f)) - a).norm();
    cumulative_[f] = sum;
  }
}

AreaSampler::Point AreaSampler::Draw(Random* random) const {
  return DrawAt(random->Uniform(), random);
}

AreaSampler::Point AreaSampler::DrawAt(double share, Random* random) const {
  const auto found =
      std::upper_bound(cumulative_.begin(), cumulative_.end(), share * cumulative_.back());
  const int64_t last = static_cast<int64_t>(cumulative_.size()) - 1;
  // (1 - sqrt r) a + sqrt r (1 - s) b + sqrt r s c is uniform in the triangle.
  const double root = std::sqrt(random->Uniform()), s = random->Uniform();
  return {std::min<int64_t>(found - cumulative_.begin(), last),
          {1 - root, root * (1 - s), root * s}};
}

}  // namespace cagefit
