// The cameras that `cagefit render` looks through.
#ifndef CAGEFIT_CLIENT_COMMANDS_RENDER_VIEWS_H_
#define CAGEFIT_CLIENT_COMMANDS_RENDER_VIEWS_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/types.h"
#include "core/image/camera.h"

namespace cagefit::client {

struct ViewOptions {
  std::string cameras;            // file or folder for ReadCameras; empty: virtual cameras
  std::string layout = "sphere";  // of virtual cameras: sphere or tutorial
  int count = 20;                 // virtual cameras
  int size = 0;  // pixels of the longer side; 0: the camera's own, virtual ones 256
};

// Each camera has its own name, which is fit for a file: letters, digits and ._- of its name in the
// file, without the ending of an image ("rig/left.png" becomes "rig_left"), or view_0000 and so on.
// None has distortion. INVALID_ARGUMENT for vertices (3 x n) without extent, two names that become
// the same, and what ReadCameras refuses.
absl::StatusOr<std::vector<Camera>> ChooseViews(const ViewOptions& options,
                                                const Points3d& vertices);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_RENDER_VIEWS_H_
