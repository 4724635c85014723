// Tolerances as people write them.
#ifndef CAGEFIT_CLIENT_COMMANDS_PARSE_TOLERANCE_H_
#define CAGEFIT_CLIENT_COMMANDS_PARSE_TOLERANCE_H_

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace cagefit::client {

// The share of the diagonal that "0.1%", "0.1 %" (a tenth of a percent) or "0.001" (the same as a
// share) stand for. INVALID_ARGUMENT for anything else, for what is not positive, above 10 %, and
// for a share above 1 % without a percent sign: whoever writes 0.1 means 0.1%.
absl::StatusOr<double> ParseTolerance(absl::string_view text);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_PARSE_TOLERANCE_H_
