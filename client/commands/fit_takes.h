// `cagefit fit --takes`: many captures in one call, each a take of its own.
#ifndef CAGEFIT_CLIENT_COMMANDS_FIT_TAKES_H_
#define CAGEFIT_CLIENT_COMMANDS_FIT_TAKES_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/commands/fit_options.h"

namespace cagefit::client {

struct Take {
  std::string name;        // of its folder, or of its file without the ending
  FitArguments arguments;  // one input, OUT/NAME, and {take} replaced by the name
};

// Those of the chunk, in natural order of their names. INVALID_ARGUMENT, naming both, for two of
// one name.
absl::StatusOr<std::vector<Take>> ListTakes(const FitArguments& arguments);

// Fits what is not done, one after the other. A take's session is kept until it is done, in
// OUT/NAME/session.db where no server is named, so that a call that was interrupted or killed is
// gone on with: frames that were answered are not fitted again, and the bits are those of a call
// without a break. Returns an exit code: kDone when all takes are; kNoServer ends it at once.
int FitTakes(const FitArguments& arguments);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_FIT_TAKES_H_
