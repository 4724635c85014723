#include "core/image/camera.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"

namespace cagefit {

namespace {

constexpr int kMostPixels = 16384;
constexpr double kRotationTolerance = 1e-3;
constexpr int kUndistortIterations = 100;

absl::Status Invalid(const Camera& camera, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrFormat("camera \"%s\": %s", camera.name, what));
}

}  // namespace

absl::Status Camera::Validate() const {
  for (const auto& [field, value] : {std::pair("width", width), std::pair("height", height)}) {
    if (value >= 1 && value <= kMostPixels) continue;
    return Invalid(*this, absl::StrFormat("%s is %d; expected 1 to %d", field, value, kMostPixels));
  }
  for (const auto& [field, value] : {std::pair("fx", fx), std::pair("fy", fy)}) {
    if (value > 0 && std::isfinite(value)) continue;
    return Invalid(*this, absl::StrFormat("%s is %g; expected above 0", field, value));
  }
  for (const auto& [field, value] :
       {std::pair("cx", cx), std::pair("cy", cy), std::pair("k1", distortion.k1),
        std::pair("k2", distortion.k2), std::pair("p1", distortion.p1),
        std::pair("p2", distortion.p2), std::pair("k3", distortion.k3)}) {
    if (std::isfinite(value)) continue;
    return Invalid(*this, absl::StrFormat("%s is %g; expected a finite number", field, value));
  }
  if (!t.allFinite()) return Invalid(*this, "t is not finite");
  const double error = (R * R.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (!(error < kRotationTolerance) || !(R.determinant() > 0)) {
    return Invalid(*this, absl::StrFormat("R is no rotation: |R R^T - I| is %g, determinant %g",
                                          error, R.determinant()));
  }
  return absl::OkStatus();
}

Eigen::Vector2d Distort(const Distortion& d, const Eigen::Vector2d& x) {
  const double r2 = x.squaredNorm(), xy = x[0] * x[1];
  const double radial = 1 + r2 * (d.k1 + r2 * (d.k2 + r2 * d.k3));
  return {x[0] * radial + 2 * d.p1 * xy + d.p2 * (r2 + 2 * x[0] * x[0]),
          x[1] * radial + d.p1 * (r2 + 2 * x[1] * x[1]) + 2 * d.p2 * xy};
}

Eigen::Vector2d Undistort(const Distortion& d, const Eigen::Vector2d& distorted) {
  Eigen::Vector2d x = distorted;
  if (d.is_zero()) return x;
  for (int k = 0; k < kUndistortIterations; ++k) {
    const Eigen::Vector2d error = distorted - Distort(d, x);
    x += error;
    if (error.squaredNorm() < 1e-24) break;
  }
  return x;
}

Camera Resized(const Camera& camera, int size) {
  Camera out = camera;
  const double scale = static_cast<double>(size) / std::max(camera.width, camera.height);
  out.width = std::max(1, static_cast<int>(std::lround(scale * camera.width)));
  out.height = std::max(1, static_cast<int>(std::lround(scale * camera.height)));
  const double sx = static_cast<double>(out.width) / camera.width;
  const double sy = static_cast<double>(out.height) / camera.height;
  out.fx *= sx;
  out.fy *= sy;
  out.cx = sx * (camera.cx + 0.5) - 0.5;
  out.cy = sy * (camera.cy + 0.5) - 0.5;
  return out;
}

Camera InCoordinates(const Camera& camera, const Eigen::Vector3d& center, double scale) {
  // R x + t = R (y / scale + center) + t, and the image does not change with the factor `scale`.
  Camera out = camera;
  out.t = scale * (camera.R * center + camera.t);
  return out;
}

Camera LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target, const Eigen::Vector3d& up,
              double field_of_view_rad, int size) {
  Camera camera;
  camera.width = camera.height = size;
  camera.fx = camera.fy = 0.5 * size / std::tan(0.5 * field_of_view_rad);
  camera.cx = camera.cy = 0.5 * (size - 1);
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(up).normalized();
  camera.R.row(0) = right.transpose();
  camera.R.row(1) = forward.cross(right).transpose();
  camera.R.row(2) = forward.transpose();
  camera.t = -camera.R * eye;
  return camera;
}

}  // namespace cagefit
