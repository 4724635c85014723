#include "core/fit/extrapolation.h"

#include <Eigen/Geometry>

namespace cagefit {

Points3d ExtrapolateMotion(const Points3d& before, const Points3d& now, double momentum) {
  const Eigen::Matrix4d T = Eigen::umeyama(before, now, /*with_scaling=*/false);
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const Eigen::Vector3d t = T.topRightCorner<3, 1>();
  return ((R * now).colwise() + t) + momentum * (R * (now - ((R * before).colwise() + t)));
}

}  // namespace cagefit
