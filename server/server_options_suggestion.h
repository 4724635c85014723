// What somebody may have meant who wrote a name that there is not.
#ifndef CAGEFIT_SERVER_SERVER_OPTIONS_SUGGESTION_H_
#define CAGEFIT_SERVER_SERVER_OPTIONS_SUGGESTION_H_

#include <string>
#include <vector>

#include "absl/strings/string_view.h"

namespace cagefit::server {

// "; did you mean NAME?" with the nearest of `names`, or nothing when none is near.
std::string Suggestion(absl::string_view written, const std::vector<std::string>& names);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SERVER_OPTIONS_SUGGESTION_H_
