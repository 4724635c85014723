#include "server/log.h"

#include <spdlog/sinks/null_sink.h>
#include <spdlog/sinks/stdout_sinks.h>

namespace cagefit::server {

std::shared_ptr<spdlog::logger> ConsoleLog(const std::string& level) {
  auto log = std::make_shared<spdlog::logger>("cagefitd",
                                              std::make_shared<spdlog::sinks::stderr_sink_mt>());
  log->set_pattern("%Y-%m-%dT%H:%M:%S.%eZ %l %v", spdlog::pattern_time_type::utc);
  log->set_level(spdlog::level::from_str(level));
  return log;
}

std::shared_ptr<spdlog::logger> SilentLog() {
  return std::make_shared<spdlog::logger>("cagefit",
                                          std::make_shared<spdlog::sinks::null_sink_mt>());
}

}  // namespace cagefit::server
