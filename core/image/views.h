// Where virtual cameras stand around an object.
#ifndef CAGEFIT_CORE_IMAGE_VIEWS_H_
#define CAGEFIT_CORE_IMAGE_VIEWS_H_

#include <vector>

#include "core/image/camera.h"

namespace cagefit {

inline constexpr double kFieldOfView = 60;  // degrees

// `count` >= 1 directions that cover the sphere evenly (Fibonacci), each view with a field of view
// of 60 degrees, square, and the ball of `radius` around `center` in full. Requires radius > 0.
std::vector<Camera> SphereViews(int count, const Eigen::Vector3d& center, double radius, int size);

// The views of [xie2022], which are those of PyTorch3D's tutorial: e = 360 k / (count - 1) and
// a = -180 + 360 k / (count - 1) degrees,
//
//   C = 2.7 (cos e sin a, sin e, cos e cos a),  looking at 0, up (0, 1, 0),
//
// for an object whose longest side is 2: scaled to `longest_side` > 0 and moved to `center`. They
// form a figure of eight on one half of the sphere.
std::vector<Camera> TutorialViews(int count, const Eigen::Vector3d& center, double longest_side,
                                  int size);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_VIEWS_H_
