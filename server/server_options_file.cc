#include "server/server_options_file.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

// Where a comment behind an unquoted value begins, or its size.
size_t CommentBegin(absl::string_view value) {
  for (size_t k = 0; k < value.size(); ++k) {
    if (value[k] != '#') continue;
    if (k == 0 || absl::ascii_isspace(static_cast<unsigned char>(value[k - 1]))) return k;
  }
  return value.size();
}

bool NeedsQuotes(absl::string_view value) {
  return value.empty() || value.front() == '"' || absl::StripAsciiWhitespace(value) != value ||
         CommentBegin(value) != value.size() ||
         std::any_of(value.begin(), value.end(),
                     [](unsigned char c) { return absl::ascii_iscntrl(c); });
}

absl::StatusOr<std::string> ParseValue(absl::string_view text) {
  if (!absl::StartsWith(text, "\"")) {
    return std::string(absl::StripTrailingAsciiWhitespace(text.substr(0, CommentBegin(text))));
  }
  size_t end = 1;
  while (end < text.size() && text[end] != '"') end += text[end] == '\\' ? 2 : 1;
  if (end >= text.size()) return absl::InvalidArgumentError("a quote is not closed");
  const absl::string_view rest = absl::StripLeadingAsciiWhitespace(text.substr(end + 1));
  if (!rest.empty() && rest.front() != '#') {
    return absl::InvalidArgumentError("something follows a quoted value");
  }
  std::string value, error;
  if (!absl::CUnescape(text.substr(1, end - 1), &value, &error)) {
    return absl::InvalidArgumentError(error);
  }
  return value;
}

absl::StatusOr<FileSetting> ParseLine(absl::string_view line) {
  const std::pair<absl::string_view, absl::string_view> sides =
      absl::StrSplit(line, absl::MaxSplits('=', 1));
  const absl::string_view name = absl::StripAsciiWhitespace(sides.first);
  if (name.empty() || !absl::StrContains(line, '=')) {
    return absl::InvalidArgumentError("expected name=value");
  }
  ASSIGN_OR_RETURN(std::string value, ParseValue(absl::StripAsciiWhitespace(sides.second)));
  return FileSetting{std::string(name), std::move(value)};
}

}  // namespace

absl::StatusOr<std::vector<FileSetting>> ParseSettings(absl::string_view text) {
  std::vector<FileSetting> settings;
  int number = 0;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    const absl::string_view stripped = absl::StripAsciiWhitespace(line);
    if (stripped.empty() || stripped.front() == '#') continue;
    auto setting = ParseLine(stripped);
    if (!setting.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("line ", number, ": ", setting.status().message()));
    }
    setting->line = number;
    settings.push_back(*std::move(setting));
  }
  return settings;
}

std::string SettingLine(absl::string_view name, absl::string_view value) {
  if (!NeedsQuotes(value)) return absl::StrCat(name, "=", value);
  return absl::StrCat(name, "=\"", absl::Utf8SafeCEscape(value), "\"");
}

}  // namespace cagefit::server
