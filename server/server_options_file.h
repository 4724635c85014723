// The form of a file of settings: one `name=value` a line.
//
//   # a comment, as behind a value
//   listen=127.0.0.1:50051
//   listen=unix:/run/cagefit.sock    # a list: one line for each
//   token-file="/a path # with \"anything\""
//
// Quoted values have C's escapes; others go to the line's end, or to a # behind a space.
#ifndef CAGEFIT_SERVER_SERVER_OPTIONS_FILE_H_
#define CAGEFIT_SERVER_SERVER_OPTIONS_FILE_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace cagefit::server {

struct FileSetting {
  std::string name, value;
  int line = 0;  // from 1
};

// INVALID_ARGUMENT naming the line for what is not of this form. Names are not checked.
absl::StatusOr<std::vector<FileSetting>> ParseSettings(absl::string_view text);

// A line, without its end, that ParseSettings reads back.
std::string SettingLine(absl::string_view name, absl::string_view value);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SERVER_OPTIONS_FILE_H_
