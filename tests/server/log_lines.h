// A log that a test can read.
#ifndef CAGEFIT_TESTS_SERVER_LOG_LINES_H_
#define CAGEFIT_TESTS_SERVER_LOG_LINES_H_

#include <spdlog/logger.h>
#include <spdlog/sinks/base_sink.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace cagefit::server::testing {

// Thread-safe.
class LogLines {
 public:
  // Everything from trace on.
  std::shared_ptr<spdlog::logger> log() {
    auto log = std::make_shared<spdlog::logger>("test", std::make_shared<Sink>(this));
    log->set_level(spdlog::level::trace);
    return log;
  }

  // False when no line with `text` comes within 20 s. Lines up to that one are then seen.
  bool WaitFor(const std::string& text) {
    std::unique_lock<std::mutex> lock(mutex_);
    return added_.wait_for(lock, std::chrono::seconds(20), [&] {
      const auto found = std::find_if(lines_.begin() + seen_, lines_.end(), [&](const auto& line) {
        return line.find(text) != std::string::npos;
      });
      if (found == lines_.end()) return false;
      seen_ = found - lines_.begin() + 1;
      return true;
    });
  }
  std::string All() {
    std::lock_guard<std::mutex> lock(mutex_);
    std::string all;
    for (const std::string& line : lines_) all += line + "\n";
    return all;
  }

 private:
  class Sink : public spdlog::sinks::base_sink<std::mutex> {
   public:
    explicit Sink(LogLines* lines) : lines_(lines) {}

   private:
    void sink_it_(const spdlog::details::log_msg& message) override {
      std::lock_guard<std::mutex> lock(lines_->mutex_);
      lines_->lines_.emplace_back(message.payload.data(), message.payload.size());
      lines_->added_.notify_all();
    }
    void flush_() override {}

    LogLines* const lines_;
  };

  std::mutex mutex_;
  std::condition_variable added_;
  std::vector<std::string> lines_;
  std::ptrdiff_t seen_ = 0;
};

}  // namespace cagefit::server::testing

#endif  // CAGEFIT_TESTS_SERVER_LOG_LINES_H_
