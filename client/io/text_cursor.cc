#include "client/io/text_cursor.h"

#include <charconv>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"

namespace cagefit::client {
namespace {

constexpr size_t kQuotedBytes = 60;

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
bool IsLineEnd(char c) { return c == '\n' || c == '\r'; }

// std::from_chars takes no plus sign.
absl::string_view WithoutPlus(absl::string_view word) {
  const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-';
  return plus ? word.substr(1) : word;
}

template <typename Value>
bool Parse(absl::string_view word, Value* value) {
  word = WithoutPlus(word);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), *value);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace

bool ParseDouble(absl::string_view word, double* value) { return Parse(word, value); }
bool ParseInt(absl::string_view word, int64_t* value) { return Parse(word, value); }

bool TextCursor::NextLine(absl::string_view* line) {
  in_line_ = false;
  if (at_ >= text_.size()) return false;
  const size_t end = text_.find_first_of("\r\n", at_);
  ++line_;
  if (end == absl::string_view::npos) {
    *line = text_.substr(at_);
    at_ = text_.size();
    return true;
  }
  *line = text_.substr(at_, end - at_);
  at_ = end + 1;
  if (text_[end] == '\r' && at_ < text_.size() && text_[at_] == '\n') ++at_;
  return true;
}

absl::string_view TextCursor::NextWord() {
  while (at_ < text_.size()) {
    if (!in_line_) ++line_;
    in_line_ = true;
    const char c = text_[at_];
    if (IsLineEnd(c)) {
      at_ += c == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n' ? 2 : 1;
      in_line_ = false;
    } else if (IsSpace(c)) {
      ++at_;
    } else {
      break;
    }
  }
  const size_t begin = at_;
  while (at_ < text_.size() && !IsSpace(text_[at_]) && !IsLineEnd(text_[at_])) ++at_;
  return text_.substr(begin, at_ - begin);
}

void SplitWords(absl::string_view line, absl::string_view separators, char comment,
                std::vector<absl::string_view>* words) {
  words->clear();
  size_t begin = 0;
  for (size_t at = 0; at <= line.size(); ++at) {
    const bool ends = at == line.size() || (comment != 0 && line[at] == comment);
    if (!ends && !IsSpace(line[at]) && !absl::StrContains(separators, line[at])) continue;
    if (at > begin) words->push_back(line.substr(begin, at - begin));
    if (ends) return;
    begin = at + 1;
  }
}

absl::Status BadLine(int64_t line, absl::string_view text, absl::string_view expected) {
  return absl::InvalidArgumentError(
      absl::StrCat("line ", line, " is \"", absl::CEscape(text.substr(0, kQuotedBytes)),
                   text.size() > kQuotedBytes ? "...\"" : "\"", "; expected ", expected));
}

}  // namespace cagefit::client
