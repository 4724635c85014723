// The frames of a fit as its files hold them: geometry, masks, landmarks.
#ifndef CAGEFIT_CLIENT_COMMANDS_FRAME_READER_H_
#define CAGEFIT_CLIENT_COMMANDS_FRAME_READER_H_

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/commands/fit_options.h"
#include "client/commands/mask_files.h"
#include "client/fit_client.h"
#include "core/image/camera.h"

namespace cagefit::client {

class FrameReader {
 public:
  // Reads cameras and landmarks and looks for masks, of `files` in order of frames. Errors as
  // ReadCameras, ListMasks and ReadLandmarks.
  static absl::StatusOr<FrameReader> Open(const FitArguments& arguments,
                                          const std::vector<std::string>& files);

  const std::vector<Camera>& cameras() const { return cameras_; }

  // Frame `index`, whose geometry is in `file`, without a sequence number. Errors name the file.
  absl::StatusOr<OutgoingFrame> Read(size_t index, const std::string& file) const;

 private:
  int position_bits_ = 0;
  std::vector<Camera> cameras_;
  // Of every frame, where there are any.
  std::vector<std::vector<MaskFile>> masks_;
  std::vector<std::vector<v1::Landmark>> landmarks_;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_FRAME_READER_H_
