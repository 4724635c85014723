// The command line of `cagefit`.
#ifndef CAGEFIT_CLIENT_COMMANDS_PARSE_H_
#define CAGEFIT_CLIENT_COMMANDS_PARSE_H_

namespace cagefit::client {

// Reads flags over CAGEFIT_... variables over the file that --config names over defaults, runs the
// subcommand and returns the exit code.
int RunCommandLine(int argc, const char* const* argv);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_PARSE_H_
