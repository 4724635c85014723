// The server's log: one line per event on standard error.
#ifndef CAGEFIT_SERVER_LOG_H_
#define CAGEFIT_SERVER_LOG_H_

#include <spdlog/logger.h>

#include <memory>
#include <string>

namespace cagefit::server {

// Lines of time, level and name=value fields, from `level` on (a ServerOptions::log_level).
std::shared_ptr<spdlog::logger> ConsoleLog(const std::string& level);

// Drops everything: for a server inside another program.
std::shared_ptr<spdlog::logger> SilentLog();

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_LOG_H_
