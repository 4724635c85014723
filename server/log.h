// The server's log: one line per event on standard error.
#ifndef CAGEFIT_SERVER_LOG_H_
#define CAGEFIT_SERVER_LOG_H_

#include <spdlog/logger.h>

#include <memory>
#include <string>

namespace cagefit::server {

// Who logs never waits: lines go through a queue of bounded length to a thread that writes them,
// and the oldest are dropped where standard error does not take them in time.
class ConsoleLog {
 public:
  // `level` and `format` are ServerOptions::log_level and log_format.
  ConsoleLog(const std::string& level, const std::string& format);
  // Writes what is queued. The logger must not be used any more.
  ~ConsoleLog();

  const std::shared_ptr<spdlog::logger>& logger() const { return logger_; }

 private:
  struct Thread;
  std::shared_ptr<Thread> thread_;
  std::shared_ptr<spdlog::logger> logger_;
};

// Drops everything: for a server inside another program.
std::shared_ptr<spdlog::logger> SilentLog();

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_LOG_H_
