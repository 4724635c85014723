#include "server/transport/log_event.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace cagefit::server {
namespace {

// Words go without quotes, but for what could be taken for a number.
bool IsPlain(absl::string_view value) {
  const auto plain = [](unsigned char c) {
    return absl::ascii_isalnum(c) || absl::StrContains("_-./:[]%,+@", static_cast<char>(c));
  };
  double number = 0;
  return !value.empty() && std::all_of(value.begin(), value.end(), plain) &&
         !absl::SimpleAtod(value, &number);
}

}  // namespace

LogEvent& LogEvent::Add(absl::string_view key, absl::string_view value) {
  if (IsPlain(value)) {
    absl::StrAppend(&text_, " ", key, "=", value);
  } else {
    absl::StrAppend(&text_, " ", key, "=\"", absl::CEscape(value), "\"");
  }
  return *this;
}

LogEvent& LogEvent::AddInteger(absl::string_view key, uint64_t value) {
  absl::StrAppend(&text_, " ", key, "=", value);
  return *this;
}

LogEvent& LogEvent::AddNumber(absl::string_view key, double value) {
  if (!std::isfinite(value)) return Add(key, absl::StrCat(value));
  absl::StrAppendFormat(&text_, " %s=%.6g", key, value);
  return *this;
}

}  // namespace cagefit::server
