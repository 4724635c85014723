// The frames that a command line names.
#ifndef CAGEFIT_CLIENT_COMMANDS_INPUT_FILES_H_
#define CAGEFIT_CLIENT_COMMANDS_INPUT_FILES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace cagefit::client {

// "frame_9" before "frame_10": runs of digits compare as numbers.
bool NaturalLess(const std::string& a, const std::string& b);

// Files stay in the order given; a folder stands for the geometry files directly in it, in natural
// order. NOT_FOUND for what is not there, INVALID_ARGUMENT for a folder without any, for a folder
// with files of several formats, and for a file of a format that is not read.
absl::StatusOr<std::vector<std::string>> ListInputs(const std::vector<std::string>& inputs);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_INPUT_FILES_H_
