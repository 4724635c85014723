#include "client/commands/frame_reader.h"

#include "client/commands/landmark_file.h"
#include "client/encode_frame.h"
#include "client/io/camera_file.h"
#include "core/base/status.h"

namespace cagefit::client {

absl::StatusOr<FrameReader> FrameReader::Open(const FitArguments& arguments,
                                              const std::vector<std::string>& files) {
  FrameReader reader;
  reader.position_bits_ = arguments.position_bits;
  if (!arguments.landmarks.empty()) {
    ASSIGN_OR_RETURN(reader.landmarks_, ReadLandmarks(arguments.landmarks, files));
  }
  if (arguments.cameras.empty()) return reader;
  ASSIGN_OR_RETURN(reader.cameras_, ReadCameras(arguments.cameras));
  if (arguments.masks.empty()) return reader;
  std::vector<std::string> names;
  for (const Camera& camera : reader.cameras_) names.push_back(camera.name);
  ASSIGN_OR_RETURN(reader.masks_, ListMasks(arguments.masks, names, files));
  return reader;
}

absl::StatusOr<OutgoingFrame> FrameReader::Read(size_t index, const std::string& file) const {
  OutgoingFrame frame;
  ASSIGN_OR_RETURN(frame.draco, EncodeFrame(file, position_bits_));
  if (!landmarks_.empty()) frame.landmarks = landmarks_[index];
  if (masks_.empty()) return frame;
  ASSIGN_OR_RETURN(frame.masks, ReadMasks(masks_[index]));
  return frame;
}

}  // namespace cagefit::client
