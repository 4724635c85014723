#include "client/commands/fit_run.h"

#include <filesystem>
#include <iostream>

#include "absl/strings/str_cat.h"
#include "client/commands/command.h"
#include "client/commands/fit_report.h"
#include "client/commands/input_files.h"
#include "client/status_from_grpc.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

absl::Status CheckArguments(const FitArguments& arguments) {
  if (arguments.cage.empty() && arguments.vertices == 0 && !arguments.options.has_tolerance() &&
      arguments.session.empty()) {
    return absl::InvalidArgumentError(
        "expected --template CAGE, or --vertices N or --tolerance T to make one");
  }
  if (!arguments.follow) return absl::OkStatus();
  if (arguments.inputs.size() == 1 && std::filesystem::is_directory(arguments.inputs.front())) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError("--follow: INPUT must be one folder");
}

// Of `count` frames.
absl::Status CheckRange(const FitArguments& arguments, size_t count) {
  if (arguments.from_frame >= count) {
    return absl::InvalidArgumentError(absl::StrCat("--from-frame is ", arguments.from_frame,
                                                   "; the input has frames 0 to ", count - 1));
  }
  const size_t last = arguments.to_frame.value_or(count - 1);
  if (last >= count || last < arguments.from_frame) {
    return absl::InvalidArgumentError(absl::StrCat("--to-frame is ", last,
                                                   "; expected one of the frames ",
                                                   arguments.from_frame, " to ", count - 1));
  }
  if (arguments.round_trip && last == arguments.from_frame) {
    return absl::InvalidArgumentError(
        absl::StrCat("--round-trip needs a sequence; there is only frame ", last));
  }
  return absl::OkStatus();
}

int ExitCodeOf(const FitReport& report) {
  const FitTotals totals = Totals(report);
  if (totals.fitted == 0) return kFailed;
  const bool all = totals.skipped + totals.refused + totals.unanswered + totals.lost == 0 &&
                   !totals.beyond_tolerance;
  return all ? kDone : kPartlyDone;
}

int ExitCodeWithoutSession(const absl::Status& failure) {
  if (absl::IsInvalidArgument(failure)) return kWrongUsage;
  return absl::IsUnavailable(failure) ? kNoServer : kFailed;
}

}  // namespace

absl::StatusOr<FitInput> OpenInput(const FitArguments& arguments) {
  RETURN_IF_ERROR(CheckArguments(arguments));
  FitInput input;
  if (arguments.follow) {
    FollowOptions options;
    options.settle = absl::Seconds(arguments.follow_settle);
    if (arguments.follow_idle > 0) options.idle = absl::Seconds(arguments.follow_idle);
    ASSIGN_OR_RETURN(input.follower, FolderFollower::Open(arguments.inputs.front(), options));
    return input;
  }
  ASSIGN_OR_RETURN(input.files, ListInputs(arguments.inputs));
  RETURN_IF_ERROR(CheckRange(arguments, input.files.size()));
  if (arguments.truth.empty()) return input;
  ASSIGN_OR_RETURN(input.truth, TrueMotion::Open(arguments.truth, input.files.size()));
  RETURN_IF_ERROR(input.truth->Check());
  return input;
}

FitEnd RunFit(FitJob* job, const std::function<absl::Status(const std::string&)>& on_session) {
  FitEnd end;
  end.failure = job->Begin();
  end.has_begun = end.failure.ok();
  if (!end.has_begun) {
    end.exit_code = ExitCodeWithoutSession(end.failure);
    return end;
  }
  if (on_session) end.failure = on_session(job->report().session.session_id());
  if (end.failure.ok()) end.failure = job->Run();
  end.written = job->Finish();
  if (!end.failure.ok()) {
    end.exit_code = Totals(job->report()).fitted > 0 ? kPartlyDone : kFailed;
  } else if (!end.written.ok()) {
    end.failure = end.written;
    end.exit_code = kFailed;
  } else {
    end.exit_code = ExitCodeOf(job->report());
    job->DeleteSession();
  }
  return end;
}

bool MayGoOn(const absl::Status& failure) {
  const bool is_of_a_file = absl::IsFailedPrecondition(failure) && !DetailOf(failure).has_value();
  return absl::IsCancelled(failure) || MayPass(failure) || is_of_a_file;
}

void SayWhatWasRefused(const FitReport& report) {
  for (size_t k = report.first_frame; k < report.frames.size(); ++k) {
    const FrameRecord& frame = report.frames[k];
    if (frame.status.ok() || frame.reply.outcome() == v1::OUTCOME_SKIPPED) continue;
    std::cerr << "cagefit: " << frame.file << " was refused: " << frame.status.message() << "\n";
  }
}

}  // namespace cagefit::client
