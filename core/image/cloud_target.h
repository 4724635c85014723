// The target that a point cloud is, seen by a camera.
//
// The silhouette is that of the region which the projected points cover: the closing of
// core/image/point_outline.h, with radii in proportion to the points' spacing s as projected at
// their median depth,
//
//   radius = max(1 pixel, 1.5 s),   hole_radius = max(1 pixel, 3 s)
//
// so that gaps by chance close, at any density within a factor of 4, and the outermost points stay
// where they are. Independent random points do not reach the edge of the surface they are drawn
// from: the outline lies inside it, by 0.01 s to 0.04 s at the rim of a smooth body, where many
// points are seen close to the outline, and by 0.45 s where an open sheet ends. That is not
// corrected, since points of a mesh or of a regular scan reach the edge, and the points do not tell
// which they are; the distance to the cloud, which the fit compares too, ends at the same points.
//
// Depth and normals: core/image/point_surface.h with a tolerance of twice the spacing.
#ifndef CAGEFIT_CORE_IMAGE_CLOUD_TARGET_H_
#define CAGEFIT_CORE_IMAGE_CLOUD_TARGET_H_

#include <vector>

#include "core/cloud/point_cloud.h"
#include "core/image/image_target.h"
#include "core/image/point_outline.h"
#include "core/image/point_surface.h"
#include "core/image/silhouette_image.h"

namespace cagefit {

enum class SplatImages { kSilhouette, kAll };

// Buffers keep their capacity from view to view. One thread at a time; the result is the same to
// the bit for any number of threads.
class CloudSplatter {
 public:
  // Requires a camera without distortion; `spacing` > 0 as of MedianSpacing, in the cloud's units.
  // Points that are behind the camera, or far outside its image, count for nothing. `target` gets
  // depth and normals, too, with kAll, when the cloud has normals.
  void Splat(const PointCloud& cloud, double spacing, const Camera& camera, ImageTarget* target,
             double sigma_ndc = kSilhouetteSigma, SplatImages images = SplatImages::kAll);

  // Of the last target, in its pixels.
  const Outline& outline() const { return outline_.outline(); }

 private:
  void Project(const PointCloud& cloud, const Camera& camera);
  double MedianDepth();

  std::vector<float> u_, v_, z_;  // pixels and camera z; u is not a number behind the camera
  std::vector<float> depths_;
  PointOutline outline_;
  PointSurface surface_;
  OutlineDistance distance_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_CLOUD_TARGET_H_
