// The shell command that goes on where a `cagefit` command stopped.
#ifndef CAGEFIT_CLIENT_COMMANDS_RESUME_COMMAND_H_
#define CAGEFIT_CLIENT_COMMANDS_RESUME_COMMAND_H_

#include <string>
#include <vector>

namespace cagefit::client {

// As a POSIX shell reads one word: in single quotes where it needs any.
std::string ShellQuoted(const std::string& word);

// `words`, the program's name first, with `flag value` for what they say of that flag, if anything.
std::string CommandWith(const std::vector<std::string>& words, const std::string& flag,
                        const std::string& value);

// `words` as they are.
std::string Command(const std::vector<std::string>& words);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_RESUME_COMMAND_H_
