#include "server/log.h"

#include <spdlog/async_logger.h>
#include <spdlog/details/thread_pool.h>
#include <spdlog/sinks/null_sink.h>
#include <spdlog/sinks/stdout_sinks.h>

#include "server/log_format.h"

namespace cagefit::server {
namespace {

constexpr size_t kQueuedLines = 8192;

}  // namespace

struct ConsoleLog::Thread : spdlog::details::thread_pool {
  Thread() : thread_pool(kQueuedLines, /*threads_n=*/1) {}
};

ConsoleLog::ConsoleLog(const std::string& level, const std::string& format)
    : thread_(std::make_shared<Thread>()),
      logger_(std::make_shared<spdlog::async_logger>(
          "cagefitd", std::make_shared<spdlog::sinks::stderr_sink_mt>(), thread_,
          spdlog::async_overflow_policy::overrun_oldest)) {
  logger_->set_formatter(MakeFormatter(format == "json" ? JsonLine : TextLine));
  logger_->set_level(spdlog::level::from_str(level));
}

ConsoleLog::~ConsoleLog() = default;

std::shared_ptr<spdlog::logger> SilentLog() {
  return std::make_shared<spdlog::logger>("cagefit",
                                          std::make_shared<spdlog::sinks::null_sink_mt>());
}

}  // namespace cagefit::server
