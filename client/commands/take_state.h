// What is known of a take from an earlier call: OUT/NAME/take.json.
#ifndef CAGEFIT_CLIENT_COMMANDS_TAKE_STATE_H_
#define CAGEFIT_CLIENT_COMMANDS_TAKE_STATE_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/commands/fit_options.h"
#include "client/commands/json.h"

namespace cagefit::client {

struct TakeState {
  Json asked;                    // as AskedOf
  std::string server, session;   // where it is fitted; server empty: the one inside
  std::optional<int> exit_code;  // set when it is done: every frame has its answer
};

// All that the results depend on: settings, and of the frames' files and those that the settings
// name, size and time of the last change. What is equal gives the same results.
Json AskedOf(const FitArguments& arguments, const std::vector<std::string>& files);

// Nothing where there is no such file, or one that cannot be read.
std::optional<TakeState> ReadTakeState(const std::string& path);
absl::Status WriteTakeState(const std::string& path, const TakeState& state);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_TAKE_STATE_H_
