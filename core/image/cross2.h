// The cross product in the plane.
#ifndef CAGEFIT_CORE_IMAGE_CROSS2_H_
#define CAGEFIT_CORE_IMAGE_CROSS2_H_

#include <Eigen/Core>

namespace cagefit {

// Positive where b is counter-clockwise from a, with x to the right and y upwards.
inline double Cross2(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a[0] * b[1] - a[1] * b[0];
}

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_CROSS2_H_
