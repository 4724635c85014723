// One line of the log: an event and its fields, as in `frame session=1f3a frame=7 error="no
// \"x\""`. Whatever a value holds, it stays one value of one line; server/log_format.h reads it
// back.
#ifndef CAGEFIT_SERVER_TRANSPORT_LOG_EVENT_H_
#define CAGEFIT_SERVER_TRANSPORT_LOG_EVENT_H_

#include <cstdint>
#include <string>

#include "absl/strings/string_view.h"

namespace cagefit::server {

class LogEvent {
 public:
  // Events and keys are words of lower-case letters, digits and underscores.
  explicit LogEvent(absl::string_view event) : text_(event) {}

  LogEvent& Add(absl::string_view key, absl::string_view value);
  LogEvent& AddInteger(absl::string_view key, uint64_t value);
  // Finite numbers of at most 6 digits; others as text.
  LogEvent& AddNumber(absl::string_view key, double value);

  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_LOG_EVENT_H_
