// Where a fit begins, or goes on.
#ifndef CAGEFIT_CLIENT_COMMANDS_FIT_SESSION_H_
#define CAGEFIT_CLIENT_COMMANDS_FIT_SESSION_H_

#include <cstddef>
#include <string>

#include "absl/status/status.h"
#include "cagefit/v1/fitting.pb.h"

namespace cagefit::client {

// The last file OUT/frames/NNNN.obj with NNNN below `frame`; empty where there is none.
std::string EarlierMesh(const std::string& out, size_t frame);

// INVALID_ARGUMENT, naming option and values, when `asked` sets one that the session does not have
// so. Presets and tolerances are not compared: a session only tells what came of them.
absl::Status CheckSameOptions(const v1::SessionOptions& asked, const v1::SessionOptions& in_force);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_FIT_SESSION_H_
