#include "client/io/text_line.h"

#include <cmath>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"

namespace cagefit::client {
namespace {

constexpr size_t kQuotedBytes = 60;

}  // namespace

bool TextLine::Next(TextCursor* cursor) {
  while (cursor->NextLine(&text)) {
    SplitWords(text, "", 0, &words);  // a # further on may belong to an image's name
    if (words.empty() || words[0][0] == '#') continue;
    number = cursor->line();
    return true;
  }
  return false;
}

absl::Status TextLine::ReadDouble(size_t column, absl::string_view field, double* value) const {
  if (ParseDouble(words[column], value) && std::isfinite(*value)) return absl::OkStatus();
  return Wrong(field, words[column], "a finite number");
}

absl::Status TextLine::ReadInt(size_t column, absl::string_view field, int64_t* value) const {
  if (ParseInt(words[column], value)) return absl::OkStatus();
  return Wrong(field, words[column], "a whole number");
}

absl::Status TextLine::Wrong(absl::string_view field, absl::string_view value,
                             absl::string_view expected) const {
  return absl::InvalidArgumentError(absl::StrCat(
      "line ", number, ": ", field, " is \"", absl::CEscape(value.substr(0, kQuotedBytes)),
      value.size() > kQuotedBytes ? "...\"" : "\"", "; expected ", expected));
}

absl::Status TextLine::Located(const absl::Status& status) const {
  return absl::Status(status.code(), absl::StrCat("line ", number, ": ", status.message()));
}

}  // namespace cagefit::client
