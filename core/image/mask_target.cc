#include "core/image/mask_target.h"

#include <cmath>
#include <limits>

#include "absl/strings/str_format.h"
#include "core/base/parallel.h"
#include "core/image/marching_squares.h"

namespace cagefit {

namespace {

constexpr float kLevel = 0.5f;
constexpr int64_t kGrain = 256;

Eigen::Vector2d OnPlane(const Camera& camera, const Eigen::Vector2d& pixel) {
  return {(pixel[0] - camera.cx) / camera.fx, (pixel[1] - camera.cy) / camera.fy};
}

Eigen::Vector2d PixelOf(const Camera& camera, const Eigen::Vector2d& x) {
  return {camera.fx * x[0] + camera.cx, camera.fy * x[1] + camera.cy};
}

// Radius on the plane z = 1 from which on the distortion no longer grows with the radius, and its
// polynomial means nothing: the first root of d/dr (r + k1 r^3 + k2 r^5 + k3 r^7).
double FoldRadius(const Distortion& d, double largest) {
  constexpr int kSteps = 1000;
  for (int i = 1; i <= kSteps; ++i) {
    const double r = largest * i / kSteps, r2 = r * r;
    if (1 + r2 * (3 * d.k1 + r2 * (5 * d.k2 + r2 * 7 * d.k3)) <= 0) return r;
  }
  return std::numeric_limits<double>::infinity();
}

// Moves the outline's points from the raw mask to the pixels of `pinhole`. Those that no light ray
// within `fold` reaches are moved to infinity, where they count for nothing.
void Undistort(const Camera& raw, const Camera& pinhole, double fold, Outline* outline) {
  constexpr double kTolerance = 1e-6;
  ParallelFor(outline->points.cols(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const Eigen::Vector2d distorted = OnPlane(raw, outline->points.col(i));
      const Eigen::Vector2d x = Undistort(raw.distortion, distorted);
      const bool found = (Distort(raw.distortion, x) - distorted).norm() < kTolerance;
      if (found && x.norm() < fold) {
        outline->points.col(i) = PixelOf(pinhole, x);
      } else {
        outline->points.col(i).setConstant(std::numeric_limits<double>::infinity());
      }
    }
  });
}

// Per pixel of `pinhole`: is it within the raw mask's pixel areas, and is it inside there.
void SampleMask(const Image& mask, const Camera& raw, const Camera& pinhole, double fold,
                Image* observed, Image* inside) {
  *observed = Image(pinhole.width, pinhole.height);
  *inside = Image(pinhole.width, pinhole.height);
  ParallelFor(pinhole.height, 16, [&](int64_t begin, int64_t end) {
    for (int y = static_cast<int>(begin); y < end; ++y) {
      for (int x = 0; x < pinhole.width; ++x) {
        const Eigen::Vector2d ray = OnPlane(pinhole, {x, y});
        if (!(ray.norm() < fold)) continue;
        const Eigen::Vector2d p = PixelOf(raw, Distort(raw.distortion, ray));
        if (!(p.minCoeff() >= -0.5) || !(p[0] <= mask.width - 0.5) || !(p[1] <= mask.height - 0.5))
          continue;
        *observed->at(x, y) = 1;
        *inside->at(x, y) = InsideOutline(mask, kLevel, p) ? 1.0f : 0.0f;
      }
    }
  });
}

}  // namespace

absl::StatusOr<ImageTarget> MaskTarget(const Image& mask, const Camera& camera, int size,
                                       double sigma_ndc) {
  if (mask.width != camera.width || mask.height != camera.height) {
    return absl::InvalidArgumentError(
        absl::StrFormat("mask of camera \"%s\" is %d x %d pixels; the camera has %d x %d",
                        camera.name, mask.width, mask.height, camera.width, camera.height));
  }
  if (mask.channels != 1) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "mask of camera \"%s\" has %d channels; expected 1", camera.name, mask.channels));
  }
  ImageTarget target;
  target.camera = Resized(camera, size);
  target.camera.distortion = Distortion();
  const Camera& pinhole = target.camera;
  const double corner =
      OnPlane(pinhole, {-0.5, -0.5})
          .cwiseAbs()
          .cwiseMax(OnPlane(pinhole, {pinhole.width - 0.5, pinhole.height - 0.5}).cwiseAbs())
          .norm();
  const double fold = FoldRadius(camera.distortion, 2 * corner);

  Outline outline;
  ExtractOutline(mask, kLevel, &outline);
  Undistort(camera, pinhole, fold, &outline);
  OutlineDistance distance;
  MeasureOutline(outline, pinhole.width, pinhole.height,
                 SilhouetteReach(sigma_ndc, pinhole.half_side()), &distance);
  Image inside;
  SampleMask(mask, camera, pinhole, fold, &target.observed, &inside);
  target.silhouette = SilhouetteFromOutline(distance, inside, sigma_ndc, pinhole.half_side());
  return target;
}

}  // namespace cagefit
