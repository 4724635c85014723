#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/commands/command.h"
#include "client/commands/fit_job.h"
#include "client/commands/fit_options.h"
#include "client/commands/fit_report.h"
#include "client/commands/folder_follower.h"
#include "client/commands/input_files.h"
#include "client/commands/interrupt.h"
#include "client/commands/resume_command.h"
#include "client/commands/true_motion.h"
#include "client/status_from_grpc.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

// What a fit reads; made and checked before a long fit begins.
struct FitInput {
  std::vector<std::string> files;
  std::unique_ptr<FolderFollower> follower;  // that brings the files instead
  std::optional<TrueMotion> truth;
};

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
  const size_t count = input.files.size();
  if (arguments.from_frame >= count) {
    return absl::InvalidArgumentError(absl::StrCat("--from-frame is ", arguments.from_frame,
                                                   "; the input has frames 0 to ", count - 1));
  }
  if (arguments.round_trip && count - arguments.from_frame < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat("--round-trip needs a sequence; there is only ", input.files.back()));
  }
  if (arguments.truth.empty()) return input;
  ASSIGN_OR_RETURN(input.truth, TrueMotion::Open(arguments.truth, count));
  RETURN_IF_ERROR(input.truth->Check());
  return input;
}

int ExitCodeOf(const FitReport& report) {
  const FitTotals totals = Totals(report);
  if (totals.fitted == 0) return kFailed;
  const bool all = totals.skipped + totals.refused + totals.unanswered + totals.lost == 0 &&
                   !totals.beyond_tolerance;
  return all ? kDone : kPartlyDone;
}

// Whether the session is as it was, and whatever ended the fit may pass: an interruption, a server
// that is away, a file that could not be written.
bool MayGoOn(const absl::Status& status) {
  const bool is_of_a_file = absl::IsFailedPrecondition(status) && !DetailOf(status).has_value();
  return absl::IsCancelled(status) || MayPass(status) || is_of_a_file;
}

// How to go on after a fit that broke off.
void SayHowToGoOn(const FitArguments& arguments, const std::vector<std::string>& words,
                  const FitJob& job) {
  if (!arguments.server.empty()) {
    const std::string& id = job.report().session.session_id();
    std::cerr << "cagefit: the session stays on the server; this command goes on with it:\n  "
              << CommandWith(words, "--session", id)
              << "\nor, to give it up: " << ShellQuoted(words.front()) << " session delete " << id
              << " --server " << ShellQuoted(arguments.server) << "\n";
    return;
  }
  const size_t missing = job.first_missing();
  const bool has_earlier = missing > job.report().first_frame && !arguments.round_trip;
  if (!has_earlier) {
    std::cerr << "cagefit: the session went with the server inside this program; this command "
                 "starts again:\n  "
              << Command(words) << "\n";
    return;
  }
  std::cerr << "cagefit: the session went with the server inside this program; this command starts "
               "a new one at frame "
            << missing << ", from the control mesh before it:\n  "
            << CommandWith(words, "--from-frame", absl::StrCat(missing)) << "\n";
}

// Says what went wrong and what is left of the work.
int ReportBrokenOff(const absl::Status& status, bool interrupted, const FitReport& report) {
  const int fitted = Totals(report).fitted;
  std::cerr << "cagefit: "
            << (interrupted && absl::IsCancelled(status) ? std::string("interrupted")
                                                         : std::string(status.message()))
            << "; " << fitted << " of " << report.frames.size() - report.first_frame
            << " frames are fitted\n";
  return fitted > 0 ? kPartlyDone : kFailed;
}

void SayWhatWasRefused(const FitReport& report) {
  for (size_t k = report.first_frame; k < report.frames.size(); ++k) {
    const FrameRecord& frame = report.frames[k];
    if (frame.status.ok() || frame.reply.outcome() == v1::OUTCOME_SKIPPED) continue;
    std::cerr << "cagefit: " << frame.file << " was refused: " << frame.status.message() << "\n";
  }
}

void Print(const FitArguments& arguments, const FitReport& report) {
  if (arguments.json) {
    Json json = ReportJson(report);
    json.erase("frames");
    std::cout << json.dump() << "\n";
  } else if (Totals(report).fitted > 0) {
    PrintFitTable(report, std::cout);
    std::cout << "Control meshes: " << arguments.out << "/frames and " << arguments.out
              << "/cage.obj; report: " << arguments.out << "/report.json\n";
  }
}

int Fit(const FitArguments& arguments, const std::vector<std::string>& words) {
  auto input = OpenInput(arguments);
  if (!input.ok()) {
    Report(input.status());
    return kWrongUsage;
  }
  Interrupt interrupt;
  FitJob job(arguments, std::move(input->files), input->follower.get(), std::move(input->truth),
             &interrupt);
  const absl::Status done = job.Run();
  if (!job.has_begun()) {
    const int exit_code = Report(done);
    return absl::IsInvalidArgument(done) ? static_cast<int>(kWrongUsage) : exit_code;
  }
  const absl::Status written = job.Finish();
  if (written.ok()) {
    Print(arguments, job.report());
  } else {
    Report(written);
  }
  const absl::Status failure = done.ok() ? written : done;
  if (failure.ok()) {
    job.DeleteSession();
    SayWhatWasRefused(job.report());
    return ExitCodeOf(job.report());
  }
  const int exit_code = done.ok() ? kFailed : ReportBrokenOff(done, interrupt.seen(), job.report());
  // The session stays in any case: it may be another client's by now, and holds what was fitted.
  if (MayGoOn(failure)) SayHowToGoOn(arguments, words, job);
  return exit_code;
}

}  // namespace

void AddFitCommand(CLI::App* app, const std::vector<std::string>* words, Run* run) {
  const auto arguments = std::make_shared<FitArguments>();
  CLI::App* command =
      app->add_subcommand("fit", "Fit a control mesh to a capture, frame after frame");
  AddFitFlags(arguments.get(), command);
  command->callback(
      [arguments, words, run] { *run = [arguments, words] { return Fit(*arguments, *words); }; });
}

}  // namespace cagefit::client
