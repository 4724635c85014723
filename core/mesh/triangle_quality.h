// How far a triangle is from a needle.
#ifndef CAGEFIT_CORE_MESH_TRIANGLE_QUALITY_H_
#define CAGEFIT_CORE_MESH_TRIANGLE_QUALITY_H_

#include <Eigen/Geometry>
#include <cmath>

namespace cagefit {

// 4 sqrt(3) area / sum of squared sides: 1 for an equilateral triangle, 0 for one without area.
inline double TriangleQuality(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                              const Eigen::Vector3d& c) {
  const double sides = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
  return sides > 0 ? 2 * std::sqrt(3.0) * (b - a).cross(c - a).norm() / sides : 0;
}

}  // namespace cagefit

#endif  // CAGEFIT_CORE_MESH_TRIANGLE_QUALITY_H_
