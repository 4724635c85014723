// Subcommands of `cagefit`. Each has one file, which declares its flags and does its work.
#ifndef CAGEFIT_CLIENT_COMMANDS_COMMAND_H_
#define CAGEFIT_CLIENT_COMMANDS_COMMAND_H_

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace cagefit::client {

enum ExitCode {
  kDone = 0,
  kFailed = 1,
  kWrongUsage = 2,
  kNoServer = 3,
  kPartlyDone = 4,  // frames refused, skipped or LOST, or the sequence broken off
};

// What is to be done once the command line is read; returns an exit code.
using Run = std::function<int()>;

void AddEvaluateCommand(CLI::App* app, Run* run);
// `words`: the command line with what came from variables, once it is read; it outlives the run.
void AddFitCommand(CLI::App* app, const std::vector<std::string>* words, Run* run);
void AddHealthCommand(CLI::App* app, Run* run);
void AddRefineCommand(CLI::App* app, Run* run);
void AddRenderCommand(CLI::App* app, Run* run);
void AddSessionCommand(CLI::App* app, Run* run);
void AddSynthCommand(CLI::App* app, Run* run);
// With or without template making in this build; without it, running the command says so.
void AddTemplateCommand(CLI::App* app, Run* run);
void AddTokenCommand(CLI::App* app, Run* run);

// Prints "cagefit: MESSAGE" on standard error and returns the exit code for the status.
int Report(const absl::Status& status);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_COMMAND_H_
