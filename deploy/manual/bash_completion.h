// Completion of command lines in bash, from a program's options.
#ifndef CAGEFIT_DEPLOY_MANUAL_BASH_COMPLETION_H_
#define CAGEFIT_DEPLOY_MANUAL_BASH_COMPLETION_H_

#include <CLI/CLI.hpp>
#include <string>

namespace cagefit::manual {

// A script that completes subcommands, options, values that are one of a list, and else names of
// files.
std::string BashCompletion(const CLI::App& app);

}  // namespace cagefit::manual

#endif  // CAGEFIT_DEPLOY_MANUAL_BASH_COMPLETION_H_
