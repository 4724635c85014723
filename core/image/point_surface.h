// Depth and normals of the visible side of an oriented cloud, per pixel.
//
// Of the points that face the camera and are seen within `radius` pixels of a pixel, the nearest
// one and those within `tolerance` of its tangent plane are the front sheet. With weights w_i = (1
// - rho_i^2 / radius^2)^2 of their distances rho_i in the image, n = sum w_i n_i normalised, and
// the pixel's ray z d with d_z = 1, the surface is where
//
//   sum_i w_i (n_i + n) . (p_i - z d) = 0
//
// The chord between two points of a circle is perpendicular to the sum of their normals, so that
// curvature, which puts the points' mean inside the surface and their tangent planes outside,
// cancels to second order. Pixels whose front sheet has few points, or lies to one side of them, or
// is seen at less than 6 degrees, have no surface.
#ifndef CAGEFIT_CORE_IMAGE_POINT_SURFACE_H_
#define CAGEFIT_CORE_IMAGE_POINT_SURFACE_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/cloud/point_cloud.h"
#include "core/image/camera.h"
#include "core/image/image.h"
#include "core/image/pixel_buckets.h"

namespace cagefit {

// Buffers keep their capacity from call to call.
class PointSurface {
 public:
  // Writes camera z to `depth` and unit normals in world axes, three channels, to `normals`, where
  // `inside` (one channel) is 1 and the surface is known, else 0. `cloud` has normals; (u[i], v[i])
  // is where the pinhole `camera` sees its point i, not numbers where it does not. `window` holds
  // the pixels that are inside. `radius` in pixels, `tolerance` in the cloud's units. Requires
  // `inside` to be the camera's size.
  void Build(const PointCloud& cloud, const Camera& camera, const std::vector<float>& u,
             const std::vector<float>& v, const Image& inside, const PixelWindow& window,
             double radius, double tolerance, Image* depth, Image* normals);

 private:
  struct SurfacePoint {
    Eigen::Array4f normal;    // camera axes; 1
    Eigen::Array4f position;  // camera axes; normal . position
    float u, v;               // from the window's first pixel
  };

  void SortFacing(const PointCloud& cloud, const Camera& camera, const std::vector<float>& u,
                  const std::vector<float>& v, const PixelWindow& window);
  void FindNearest(int span);
  bool FitPixel(int x, int y, float radius, float tolerance, const Eigen::Vector3f& ray,
                float* depth, Eigen::Vector3f* normal) const;

  PixelBuckets pixels_;
  std::vector<float> facing_u_;
  std::vector<SurfacePoint> points_;  // sorted
  // Per pixel, the nearest point within the span: the bits of its depth, then its index.
  std::vector<uint64_t> nearest_in_row_, nearest_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_POINT_SURFACE_H_
