#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/commands/command.h"
#include "client/commands/fit_job.h"
#include "client/commands/fit_options.h"
#include "client/commands/fit_report.h"
#include "client/commands/fit_run.h"
#include "client/commands/fit_takes.h"
#include "client/commands/interrupt.h"
#include "client/commands/resume_command.h"

namespace cagefit::client {
namespace {

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
void ReportBrokenOff(const absl::Status& status, bool interrupted, const FitReport& report) {
  std::cerr << "cagefit: "
            << (interrupted && absl::IsCancelled(status) ? std::string("interrupted")
                                                         : std::string(status.message()))
            << "; " << Totals(report).fitted << " of " << report.frames.size() - report.first_frame
            << " frames are fitted\n";
}

void Print(const FitArguments& arguments, const FitReport& report) {
  if (arguments.json) {
    Json json = ReportJson(report);
    json.erase("frames");
    std::cout << Text(json) << "\n";
  } else if (Totals(report).fitted > 0) {
    PrintFitTable(report, std::cout);
    std::cout << "Control meshes: " << arguments.out << "/frames and " << arguments.out
              << "/cage.obj; report: " << arguments.out
              << (arguments.report ? "/report.html and report.json\n" : "/report.json\n");
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
  const FitEnd end = RunFit(&job);
  if (!end.has_begun) {
    Report(end.failure);
    return end.exit_code;
  }
  if (end.written.ok()) {
    Print(arguments, job.report());
  } else {
    Report(end.written);
  }
  if (end.failure.ok()) {
    SayWhatWasRefused(job.report());
    return end.exit_code;
  }
  if (end.failure != end.written) ReportBrokenOff(end.failure, interrupt.seen(), job.report());
  // The session stays in any case: it may be another client's by now, and holds what was fitted.
  if (MayGoOn(end.failure)) SayHowToGoOn(arguments, words, job);
  return end.exit_code;
}

}  // namespace

void AddFitCommand(CLI::App* app, const std::vector<std::string>* words, Run* run) {
  const auto arguments = std::make_shared<FitArguments>();
  CLI::App* command =
      app->add_subcommand("fit", "Fit a control mesh to a capture, frame after frame");
  AddFitFlags(arguments.get(), command);
  command->callback([arguments, words, run] {
    *run = [arguments, words] {
      return arguments->takes ? FitTakes(*arguments) : Fit(*arguments, *words);
    };
  });
}

}  // namespace cagefit::client
