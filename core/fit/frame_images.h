// The images that a frame's fit is held to.
#ifndef CAGEFIT_CORE_FIT_FRAME_IMAGES_H_
#define CAGEFIT_CORE_FIT_FRAME_IMAGES_H_

#include <vector>

#include "absl/status/status.h"
#include "core/cloud/point_cloud.h"
#include "core/fit/frame_source.h"
#include "core/fit/image_options.h"
#include "core/fit/normalization.h"
#include "core/image/cloud_target.h"
#include "core/image/image_target.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

// Not thread-safe. Buffers keep their capacity.
class FrameImages {
 public:
  // Makes the images of the views that the options ask for: of the masks, with Views::kCameras;
  // else of the mesh, or of `cloud` (unit coordinates), whose points are `spacing` apart.
  // INVALID_ARGUMENT as MaskTarget says.
  absl::Status Build(const FrameSource& source, const PointCloud& cloud, double spacing,
                     const Normalization& normalization, const ImageOptions& options);

  // In unit coordinates. Empty: the frame has no images.
  const std::vector<ImageTarget>& targets() const { return targets_; }

 private:
  absl::Status BuildFromMasks(const FrameSource& source, const Normalization& normalization,
                              const ImageOptions& options);
  void BuildFromMesh(const TriangleMesh& mesh, const Normalization& normalization,
                     const std::vector<Camera>& cameras, const ImageOptions& options);
  void BuildFromCloud(const PointCloud& cloud, double spacing, const std::vector<Camera>& cameras,
                      const ImageOptions& options);

  std::vector<ImageTarget> targets_;
  std::vector<CloudSplatter> splatters_;  // one per view
};

// What the renderer is told for these options.
SilhouetteOptions RenderOptions(const ImageOptions& options);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_FRAME_IMAGES_H_
