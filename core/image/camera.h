// Calibrated cameras in OpenCV's convention: x right, y down, z forward, pixel centres at integers.
//
//   (x, y, z) = R X + t,   u = fx x' + cx,   v = fy y' + cy,   (x', y') = distort(x / z, y / z)
//
// with the lens distortion of [brown1966], r^2 = x^2 + y^2:
//
//   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2)
//   y' = y (1 + k1 r^2 + k2 r^4 + k3 r^6) + p1 (r^2 + 2 y^2) + 2 p2 x y
#ifndef CAGEFIT_CORE_IMAGE_CAMERA_H_
#define CAGEFIT_CORE_IMAGE_CAMERA_H_

#include <Eigen/Core>
#include <string>

#include "absl/status/status.h"
#include "core/base/types.h"

namespace cagefit {

struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
  bool is_zero() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0; }
};

struct Camera {
  std::string name;                                 // of its masks; may be empty
  int width = 0, height = 0;                        // pixels, 1 to 16,384
  double fx = 0, fy = 0, cx = 0, cy = 0;            // pixels
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // world to camera
  Eigen::Vector3d t = Eigen::Vector3d::Zero();      // world units
  Distortion distortion;

  // INVALID_ARGUMENT naming the field and its value.
  absl::Status Validate() const;

  Eigen::Vector3d center() const { return -R.transpose() * t; }  // world

  // Pixel of a point without distortion, and its depth z. Requires z != 0.
  Eigen::Vector3d Project(const Eigen::Vector3d& X) const {
    const Eigen::Vector3d x = R * X + t;
    return {fx * x[0] / x[2] + cx, fy * x[1] / x[2] + cy, x[2]};
  }

  // The unit of normalised device coordinates in pixels: half the smaller side.
  double half_side() const { return 0.5 * (width < height ? width : height); }
};

// (x, y) on the plane z = 1 to (x', y'), and back by fixed-point iteration: exact to 1e-9 for the
// distortions of real lenses.
Eigen::Vector2d Distort(const Distortion& distortion, const Eigen::Vector2d& x);
Eigen::Vector2d Undistort(const Distortion& distortion, const Eigen::Vector2d& distorted);

// The same camera with its longer side `size` pixels, the other in proportion, rounded. Pixel areas
// keep their place: cx + 0.5 scales.
Camera Resized(const Camera& camera, int size);

// Camera for the coordinates y = scale (x - center): sees the same image, depths in units of y.
Camera InCoordinates(const Camera& camera, const Eigen::Vector3d& center, double scale);

// At `eye`, looking at `target`, with `up` upwards in the image; a square image of `size` pixels.
// Requires eye != target and up not along the line of sight.
Camera LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up,
              double field_of_view_rad, int size);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_CAMERA_H_
