// Settings that do not stand on the command line: of the environment and of a file.
#ifndef CAGEFIT_SERVER_SERVER_OPTIONS_SOURCES_H_
#define CAGEFIT_SERVER_SERVER_OPTIONS_SOURCES_H_

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace cagefit::server {

// A command line that the other sources are added to, each only with what is not set yet, so that
// what comes first counts more.
struct CommandLine {
  explicit CommandLine(std::vector<std::string> given);

  std::vector<std::string> arguments;
  std::map<std::string, std::string> sources;  // by flag, such as --max-points: what set it
};

// Adds CAGEFITD_... variables. INVALID_ARGUMENT, with a suggestion, for one that no option has.
absl::Status AddEnvironment(const CLI::App& app, CommandLine* line);

// Adds the settings of the file that --config names, if it does. INVALID_ARGUMENT naming file and
// line, with a suggestion for a name that no option has; NOT_FOUND when it cannot be read.
absl::Status AddFile(const CLI::App& app, CommandLine* line);

// Options that a file may set: not those that say what to do, such as --help.
bool IsSetting(const CLI::Option& option);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SERVER_OPTIONS_SOURCES_H_
