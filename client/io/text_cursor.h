// Words and lines of a text that is in memory. Internal to client/io.
#ifndef CAGEFIT_CLIENT_IO_TEXT_CURSOR_H_
#define CAGEFIT_CLIENT_IO_TEXT_CURSOR_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"

namespace cagefit::client {

// The number that the whole word is; "inf" and "nan" in any case, with sign, count. False when it
// is none.
bool ParseDouble(absl::string_view word, double* value);
bool ParseInt(absl::string_view word, int64_t* value);

// Lines end with \n, \r\n or \r.
class TextCursor {
 public:
  explicit TextCursor(absl::string_view text) : text_(text) {}

  // The next line without its end; false at the end of the text.
  bool NextLine(absl::string_view* line);
  // The next word, on this line or a later one; empty at the end of the text.
  absl::string_view NextWord();

  int64_t line() const { return line_; }  // number of the line read last, from 1
  absl::string_view rest() const { return text_.substr(at_); }

 private:
  absl::string_view text_;
  size_t at_ = 0;
  int64_t line_ = 0;
  bool in_line_ = false;  // NextWord has begun a line that it has not ended
};

// Cuts a line at white space (and at each of `separators`) into `words`, which is cleared first.
// `comment` (0: none) ends the line.
void SplitWords(absl::string_view line, absl::string_view separators, char comment,
                std::vector<absl::string_view>* words);

// INVALID_ARGUMENT: "line 7 is "..."; expected ...", the text made printable and cut short.
absl::Status BadLine(int64_t line, absl::string_view text, absl::string_view expected);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_TEXT_CURSOR_H_
