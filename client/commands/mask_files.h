// The masks that a command line names: FOLDER/CAMERA/FRAME.png, where FRAME is the name of the
// frame's file without its ending.
#ifndef CAGEFIT_CLIENT_COMMANDS_MASK_FILES_H_
#define CAGEFIT_CLIENT_COMMANDS_MASK_FILES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/fit_client.h"

namespace cagefit::client {

struct MaskFile {
  std::string camera, path;
};

// For every frame the masks that there are, in the order of `cameras`; a missing file is a view
// that is missing. NOT_FOUND when there is no such folder, INVALID_ARGUMENT for a folder in it that
// is named after no camera, for two frames of one name, and when no frame has a mask.
absl::StatusOr<std::vector<std::vector<MaskFile>>> ListMasks(
    const std::string& folder, const std::vector<std::string>& cameras,
    const std::vector<std::string>& frames);

// As ReadFileBytes.
absl::StatusOr<std::vector<OutgoingMask>> ReadMasks(const std::vector<MaskFile>& files);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_MASK_FILES_H_
