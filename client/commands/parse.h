// The command line of `cagefit`.
#ifndef CAGEFIT_CLIENT_COMMANDS_PARSE_H_
#define CAGEFIT_CLIENT_COMMANDS_PARSE_H_

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "client/commands/command.h"

namespace cagefit::client {

// All commands and their options; parsing sets `run`. `words` as in AddFitCommand. Both must
// outlive the result.
std::unique_ptr<CLI::App> MakeApp(const std::vector<std::string>* words, Run* run);

// Reads flags over CAGEFIT_... variables over the file that --config names over defaults, runs the
// subcommand and returns the exit code.
int RunCommandLine(int argc, const char* const* argv);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_PARSE_H_
