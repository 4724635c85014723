// Landmarks of a sequence, from a text:
//
//   FRAME vertex J X Y Z       control vertex J is at X Y Z
//   FRAME surface F U V X Y Z  the place of the surface with weights 1 - U - V, U, V of the corners
//                              of triangle F is there
//
// FRAME is the name of the frame's file without its ending; J and F count from 0, as files of the
// control mesh have them. # begins a comment line.
#ifndef CAGEFIT_CLIENT_COMMANDS_LANDMARK_FILE_H_
#define CAGEFIT_CLIENT_COMMANDS_LANDMARK_FILE_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "cagefit/v1/fitting.pb.h"

namespace cagefit::client {

// For each of `frames` its landmarks, in the order of the text; a frame may have none. As
// ReadFileBytes, and INVALID_ARGUMENT that names the line for a word that is not what the format
// says, and for a frame that is not among `frames`; also for two frames of one name.
absl::StatusOr<std::vector<std::vector<v1::Landmark>>> ReadLandmarks(
    const std::string& path, const std::vector<std::string>& frames);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_LANDMARK_FILE_H_
