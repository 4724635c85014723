// Depth and normals of the visible side of an oriented cloud, per pixel.
//
// The nearest of the points that face the camera and are seen near a pixel, and those near its
// tangent plane, are the front sheet. Point i, at distance rho_i from the pixel in the image and
// h_i from that plane, has the weight
//
//   w_i = max(0, 1 - rho_i^2 / radius^2)^2 max(0, 1 - h_i^2 / tolerance^2)
//
// where radius is `tolerance` as seen at the nearest point's depth, or 1 pixel if that is more.
// With n = sum w_i n_i normalised and the pixel's ray z d, d_z = 1, the surface is where
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
#include <array>
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
  // the pixels that are inside. `tolerance` > 0 in the cloud's units; the nearest point is looked
  // for as far as that is seen at `typical_depth` > 0. Requires `inside` to be the camera's size.
  void Build(const PointCloud& cloud, const Camera& camera, const std::vector<float>& u,
             const std::vector<float>& v, const Image& inside, const PixelWindow& window,
             double tolerance, double typical_depth, Image* depth, Image* normals);

 private:
  // Fields of the sorted points: where they are seen, from the window's first pixel; camera axes.
  enum Field { kU, kV, kX, kY, kZ, kNx, kNy, kNz, kPlane, kFields };  // kPlane: normal . position

  void SortFacing(const PointCloud& cloud, const Camera& camera, const std::vector<float>& u,
                  const std::vector<float>& v, const PixelWindow& window);
  void FindNearest(int span);
  bool FitPixel(int x, int y, float focal_length, float tolerance, const Eigen::Vector3f& ray,
                float* depth, Eigen::Vector3f* normal) const;

  PixelBuckets pixels_;
  std::vector<float> facing_u_;
  std::array<std::vector<float>, kFields> points_;  // a few more entries than points
  // Per pixel, the nearest point within the span: the bits of its depth, then its index.
  std::vector<uint64_t> nearest_in_row_, nearest_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_POINT_SURFACE_H_
