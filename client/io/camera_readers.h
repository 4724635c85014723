// Cameras from and to bytes in memory. Errors are INVALID_ARGUMENT and say what is wrong and where,
// but not in which file. Internal to client/io.
#ifndef CAGEFIT_CLIENT_IO_CAMERA_READERS_H_
#define CAGEFIT_CLIENT_IO_CAMERA_READERS_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/image/camera.h"

namespace cagefit::client {

// The JSON of camera_file.h. Fields that are unknown or given twice are errors; so is skew in K.
absl::StatusOr<std::vector<Camera>> ReadCamerasJson(absl::string_view bytes);
absl::StatusOr<std::string> CamerasToJson(const std::vector<Camera>& cameras);

// Cameras of COLMAP by CAMERA_ID, without pose and name.
using ColmapIntrinsics = std::map<int64_t, Camera>;

// COLMAP's cameras.txt, a line for each: CAMERA_ID MODEL WIDTH HEIGHT PARAMS... of the models
// SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, and FULL_OPENCV with k4 = k5 = k6 = 0.
// COLMAP has the centre of the first pixel at (0.5, 0.5): cx and cy become less by that.
absl::StatusOr<ColmapIntrinsics> ReadColmapCameras(absl::string_view bytes);

// COLMAP's images.txt, two lines for each: IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, the pose
// being world to camera, then X Y POINT3D_ID of any number of points, which are not needed. The
// image's name, which may hold blanks, becomes the camera's.
absl::StatusOr<std::vector<Camera>> ReadColmapImages(absl::string_view bytes,
                                                     const ColmapIntrinsics& intrinsics);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_CAMERA_READERS_H_
