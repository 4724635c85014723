// Settings of the image loss (energy/image_term.h).
#ifndef CAGEFIT_CORE_FIT_IMAGE_OPTIONS_H_
#define CAGEFIT_CORE_FIT_IMAGE_OPTIONS_H_

#include <cstdint>
#include <optional>

#include "absl/status/status.h"
#include "core/image/mesh_renderer.h"

namespace cagefit {

// Where the cameras stand. kCameras are the session's, and images the masks of the frame; the
// others are virtual, look at each frame's points, and images are made from its mesh, or from the
// points themselves.
enum class Views { kNone, kCameras, kSphere, kTutorial };

struct ImageOptions {
  Views views = Views::kNone;    // kNone: no image loss
  std::optional<double> weight;  // beta, 0 to 1e9; not set: kImageWeightPerVertex control vertices
  double depth_weight = 0;       // of depth images, as a share of beta, per unit length squared
  double normal_weight = 0;      // of normal images, as a share of beta
  SilhouetteMode mode = SilhouetteMode::kOutline;
  int size = 256;               // pixels of an image's longer side; 64 to 2,048
  int view_count = 10;          // of virtual views; 1 to 200
  int views_per_iteration = 0;  // drawn in each; 0: all
  double sigma = 1e-4;          // 1e-8 to 1
  double blur_radius = SoftSilhouetteOptions().blur_radius;  // of kPytorch3d; 0 to 1
  int faces_per_pixel = 100;                                 // of kPytorch3d; 1 to 1,000
  uint64_t seed = 0;                                         // of the views that are drawn
  // With kCameras, and a distance beside the images: pixels of a camera by which its principal
  // point may be off. Each fit finds out by how much. 0 to 100; 0: calibration is exact.
  double calibration_error = 3;

  // INVALID_ARGUMENT naming the field, its value and its range.
  absl::Status Validate() const;
};
inline constexpr double kImageWeightPerVertex = 1e-2;

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_IMAGE_OPTIONS_H_
