// The settings in force, for people and for --config.
#ifndef CAGEFIT_SERVER_SERVER_OPTIONS_PRINT_H_
#define CAGEFIT_SERVER_SERVER_OPTIONS_PRINT_H_

#include <CLI/CLI.hpp>
#include <string>

#include "server/server_options_sources.h"

namespace cagefit::server {

// A file of settings that gives the options of `app`, which has parsed `line`, again. A comment
// says where each comes from; what is not set and has no value of its own is a comment, too.
std::string SettingsText(const CLI::App& app, const CommandLine& line);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SERVER_OPTIONS_PRINT_H_
