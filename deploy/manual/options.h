// What a manual says of an option, as CLI11 keeps it.
#ifndef CAGEFIT_DEPLOY_MANUAL_OPTIONS_H_
#define CAGEFIT_DEPLOY_MANUAL_OPTIONS_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace cagefit::manual {

// "-h", "--help"; of an argument without a dash, its name.
std::vector<std::string> NamesOf(const CLI::Option& option);

// Not a flag.
bool TakesValue(const CLI::Option& option);

// "TEXT", "FLOAT".
std::string ValueName(const CLI::Option& option);

// The values that it takes, where they are a list.
std::vector<std::string> ChoicesOf(const CLI::Option& option);

}  // namespace cagefit::manual

#endif  // CAGEFIT_DEPLOY_MANUAL_OPTIONS_H_
