// From the arguments of a fit to its exit code.
#ifndef CAGEFIT_CLIENT_COMMANDS_FIT_RUN_H_
#define CAGEFIT_CLIENT_COMMANDS_FIT_RUN_H_

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/commands/fit_job.h"
#include "client/commands/fit_options.h"
#include "client/commands/folder_follower.h"
#include "client/commands/true_motion.h"

namespace cagefit::client {

// What a fit reads; made and checked before a long fit begins.
struct FitInput {
  std::vector<std::string> files;
  std::unique_ptr<FolderFollower> follower;  // that brings the files instead
  std::optional<TrueMotion> truth;
};

// INVALID_ARGUMENT or NOT_FOUND for arguments that cannot be fitted.
absl::StatusOr<FitInput> OpenInput(const FitArguments& arguments);

struct FitEnd {
  bool has_begun = false;  // there was a session
  absl::Status failure;    // OK: every frame has its answer, and all is written
  absl::Status written;    // of the report and what belongs to it
  int exit_code = 0;       // an ExitCode
};

// Runs the job to its end; `on_session` is called with the session's id before the first frame.
FitEnd RunFit(FitJob* job, const std::function<absl::Status(const std::string&)>& on_session = {});

// Whether the session is as it was, and whatever ended the fit may pass: an interruption, a server
// that is away, a file that could not be written.
bool MayGoOn(const absl::Status& failure);

// Names the frames that were refused, on standard error.
void SayWhatWasRefused(const FitReport& report);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_FIT_RUN_H_
