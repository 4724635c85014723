// What a soak program ends with.
#ifndef CAGEFIT_TESTS_SOAK_VERDICT_H_
#define CAGEFIT_TESTS_SOAK_VERDICT_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "tests/support/history_checker.h"

namespace cagefit::testing {

// DATA_LOSS with the first sentences of CheckHistory.
absl::Status Judge(const History& history, const std::vector<std::string>& undisturbed);

// DATA_LOSS unless the server has stored exactly so many frames of the session, all fitted.
absl::Status CheckStored(const std::string& session_id, uint64_t frames,
                         const std::string& address);

// Another program of this build.
std::string ProgramBeside(const std::string& name);

// Prints an error and the command that reproduces it; the exit code.
int Report(const absl::Status& status, int argc, const char* const* argv);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SOAK_VERDICT_H_
