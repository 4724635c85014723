// Calibrated cameras in files: our JSON, or a folder with COLMAP's text model.
//
//   {"cameras": [{"name": "left", "width": 640, "height": 480,
//                 "K": [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], "R": [[...], [...], [...]],
//                 "t": [x, y, z], "distortion": {"k1": 0, "k2": 0, "p1": 0, "p2": 0, "k3": 0}}]}
//
// with the meanings of core/image/camera.h: R X + t is world to camera, pixel centres are at
// integers. "distortion" and each of its fields may be left out.
#ifndef CAGEFIT_CLIENT_IO_CAMERA_FILE_H_
#define CAGEFIT_CLIENT_IO_CAMERA_FILE_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/image/camera.h"

namespace cagefit::client {

// At least one camera, all of them valid and named differently, in the file's order. `path` is a
// JSON file, or a folder with cameras.txt and images.txt. NOT_FOUND, INVALID_ARGUMENT,
// RESOURCE_EXHAUSTED or UNAVAILABLE; the message starts with the file and names line and value, or
// for JSON camera, field and value.
absl::StatusOr<std::vector<Camera>> ReadCameras(const std::string& path);

// As JSON that reads back to the bit. Whole or not at all. INVALID_ARGUMENT for cameras that
// ReadCameras would refuse, UNAVAILABLE when it cannot be written.
absl::Status WriteCameras(const std::string& path, const std::vector<Camera>& cameras);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_CAMERA_FILE_H_
