// Matrix types that the whole of core shares. Points are columns.
#ifndef CAGEFIT_CORE_BASE_TYPES_H_
#define CAGEFIT_CORE_BASE_TYPES_H_

#include <Eigen/Core>
#include <cstdint>

namespace cagefit {

using Points3d = Eigen::Matrix<double, 3, Eigen::Dynamic>;  // 3 x N
using Points3f = Eigen::Matrix<float, 3, Eigen::Dynamic>;   // 3 x N
using Triangles =
    Eigen::Matrix<int32_t, 3, Eigen::Dynamic>;  // 3 x F, vertex indices, counter-clockwise

// Axis-aligned box. Empty when min > max.
struct Box {
  Eigen::Vector3d min = Eigen::Vector3d::Constant(1e300);
  Eigen::Vector3d max = Eigen::Vector3d::Constant(-1e300);

  bool empty() const { return min.x() > max.x(); }
  Eigen::Vector3d size() const {
    return empty() ? Eigen::Vector3d::Zero().eval() : (max - min).eval();
  }
  double diagonal() const { return size().norm(); }
};

// Bounding box of the columns of `points` (3 x N, float or double).
template <typename Derived>
Box BoundingBox(const Eigen::MatrixBase<Derived>& points) {
  Box box;
  if (points.cols() == 0) return box;
  box.min = points.rowwise().minCoeff().template cast<double>();
  box.max = points.rowwise().maxCoeff().template cast<double>();
  return box;
}

}  // namespace cagefit

#endif  // CAGEFIT_CORE_BASE_TYPES_H_
