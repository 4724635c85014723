// The outline of a shape in an image: where its silhouette ends.
#ifndef CAGEFIT_CORE_IMAGE_OUTLINE_H_
#define CAGEFIT_CORE_IMAGE_OUTLINE_H_

#include <Eigen/Core>
#include <cstdint>

namespace cagefit {

using Points2d = Eigen::Matrix<double, 2, Eigen::Dynamic>;  // 2 x N

// Segments in pixel coordinates of a camera without distortion: pixel centres at integers, x right,
// y down. In no order; they join to closed curves but for where the image ends.
struct Outline {
  Points2d points;
  Eigen::Matrix<int32_t, 2, Eigen::Dynamic> segments;  // indices of points
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_OUTLINE_H_
