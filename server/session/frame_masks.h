// The masks that come with a frame: what the session's cameras saw of it.
#ifndef CAGEFIT_SERVER_SESSION_FRAME_MASKS_H_
#define CAGEFIT_SERVER_SESSION_FRAME_MASKS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/image/camera.h"
#include "core/image/image.h"

namespace cagefit::server {

// As the client states it. A camera without one did not see the frame.
struct StatedMask {
  std::string camera;      // its name
  uint64_t png_bytes = 0;  // of the PNG, which follows that of the mask before
};

// Bytes of all masks. INVALID_ARGUMENT naming `field` when they are more than the frame's
// `total_bytes`, or a mask has none.
absl::StatusOr<uint64_t> MaskBytes(const std::string& field, const std::vector<StatedMask>& masks,
                                   uint64_t total_bytes);

// What decoding them takes at most, the images that are kept included.
int64_t DecodedMaskBytes(const std::vector<StatedMask>& masks, const std::vector<Camera>& cameras);

// One image, 1 channel, for each camera: empty where there is no mask. `bytes` holds the PNGs one
// after another, MaskBytes in all. INVALID_ARGUMENT naming `field`, camera and value for a camera
// that is unknown or named twice, an image that is not of its size, and a PNG that cannot be read.
absl::StatusOr<std::vector<Image>> DecodeMasks(const std::string& field, absl::string_view bytes,
                                               const std::vector<StatedMask>& masks,
                                               const std::vector<Camera>& cameras);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_FRAME_MASKS_H_
