// Lines of the log as text or as JSON, one line per event whatever is logged.
//
//   2026-05-04T03:02:01.123Z info frame session=ab12 frame=7 error="no \"x\""
//   {"time":"2026-05-04T03:02:01.123Z","level":"info","event":"frame","session":"ab12","frame":7,...}
//
// An event is a word and fields, as LogEvent writes them; a line of another form becomes the field
// `message` of an event called "message".
#ifndef CAGEFIT_SERVER_LOG_FORMAT_H_
#define CAGEFIT_SERVER_LOG_FORMAT_H_

#include <spdlog/formatter.h>

#include <memory>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace cagefit::server {

// Without the line's end. Control characters and bytes beyond ASCII in `event` are escaped.
std::string TextLine(absl::Time time, absl::string_view level, absl::string_view event);
// Likewise; valid JSON for any bytes.
std::string JsonLine(absl::Time time, absl::string_view level, absl::string_view event);

using FormatLine = std::string (*)(absl::Time, absl::string_view, absl::string_view);
std::unique_ptr<spdlog::formatter> MakeFormatter(FormatLine format);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_LOG_FORMAT_H_
