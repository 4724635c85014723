// Files as the frames that a server takes.
#ifndef CAGEFIT_CLIENT_ENCODE_FRAME_H_
#define CAGEFIT_CLIENT_ENCODE_FRAME_H_

#include <string>

#include "absl/status/statusor.h"

namespace cagefit::client {

// Draco bytes of a geometry file: a .drc file's own, without metadata; a mesh, kept to the bit
// (float32), so that a template can be made of it; a cloud with `position_bits` for each
// coordinate. Errors name the file.
absl::StatusOr<std::string> EncodeFrame(const std::string& path, int position_bits);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_ENCODE_FRAME_H_
