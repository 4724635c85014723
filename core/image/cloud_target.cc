#include "core/image/cloud_target.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 8192;
constexpr int64_t kDepthSamples = 1000;
constexpr double kClosing = 1.5, kHole = 3;  // radii, in spacings
constexpr double kSheet = 2;                 // radius and tolerance, in spacings
// Radii of a cloud that is coarse beside the image are limited: the work grows with their square.
constexpr double kLargestRadius = 64;  // pixels

}  // namespace

void CloudSplatter::Project(const PointCloud& cloud, const Camera& camera) {
  const int64_t count = cloud.size();
  u_.resize(count);
  v_.resize(count);
  z_.resize(count);
  const Eigen::Matrix3f R = camera.R.cast<float>();
  const Eigen::Vector3f t = camera.t.cast<float>();
  const auto fx = static_cast<float>(camera.fx), fy = static_cast<float>(camera.fy);
  const auto cx = static_cast<float>(camera.cx), cy = static_cast<float>(camera.cy);
  ParallelFor(count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const Eigen::Vector3f x = R * cloud.points.col(i) + t;
      z_[i] = x[2];
      u_[i] = x[2] > 0 ? fx * x[0] / x[2] + cx : std::numeric_limits<float>::quiet_NaN();
      v_[i] = fy * x[1] / x[2] + cy;
    }
  });
}

// Of about a thousand points in front of the camera; 0 when there are none.
double CloudSplatter::MedianDepth() {
  depths_.clear();
  const auto count = static_cast<int64_t>(z_.size());
  const int64_t step = std::max<int64_t>(1, count / kDepthSamples);
  for (int64_t i = 0; i < count; i += step) {
    if (z_[i] > 0) depths_.push_back(z_[i]);
  }
  if (depths_.empty()) return 0;
  const auto middle = depths_.begin() + static_cast<int64_t>(depths_.size() / 2);
  std::nth_element(depths_.begin(), middle, depths_.end());
  return *middle;
}

void CloudSplatter::Splat(const PointCloud& cloud, double spacing, const Camera& camera,
                          ImageTarget* target, double sigma_ndc, SplatImages images) {
  target->camera = camera;
  target->observed = Image();
  Project(cloud, camera);
  const double depth = MedianDepth();
  const double projected = depth > 0 ? spacing * std::sqrt(camera.fx * camera.fy) / depth : 0;
  const auto pixels = [&](double spacings) {
    return std::clamp(spacings * projected, 1.0, kLargestRadius);
  };
  outline_.Build(u_, v_, camera.width, camera.height, {pixels(kClosing), pixels(kHole)});
  MeasureOutline(outline_.outline(), camera.width, camera.height,
                 SilhouetteReach(sigma_ndc, camera.half_side()), &distance_);
  target->silhouette =
      SilhouetteFromOutline(distance_, outline_.inside(), sigma_ndc, camera.half_side());
  if (images == SplatImages::kAll && cloud.has_normals()) {
    surface_.Build(cloud, camera, u_, v_, outline_.inside(), outline_.window(), kSheet * spacing,
                   depth, &target->depth, &target->normals);
  } else {
    target->depth = Image();
    target->normals = Image();
  }
}

}  // namespace cagefit
