// The target that a real camera's mask is.
#ifndef CAGEFIT_CORE_IMAGE_MASK_TARGET_H_
#define CAGEFIT_CORE_IMAGE_MASK_TARGET_H_

#include "absl/status/statusor.h"
#include "core/image/image_target.h"
#include "core/image/silhouette_image.h"

namespace cagefit {

// What `mask` shows, as seen by the camera without its lens distortion, its longer side `size` >= 1
// pixels. `mask`: one channel, 0 to 1, as the camera took it. Its outline is the 0.5 contour of the
// raw mask (core/image/marching_squares.h), whose points are undistorted one by one: resizing and
// undistorting resample no image. The target has a silhouette; pixels that the raw mask does not
// show are not observed.
//
// INVALID_ARGUMENT, naming the camera, when the mask is not the camera's size or has more channels.
absl::StatusOr<ImageTarget> MaskTarget(const Image& mask, const Camera& camera, int size,
                                       double sigma_ndc = kSilhouetteSigma);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_MASK_TARGET_H_
