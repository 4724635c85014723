// One line of a text of words, as COLMAP's, and errors that name it.
#ifndef CAGEFIT_CLIENT_IO_TEXT_LINE_H_
#define CAGEFIT_CLIENT_IO_TEXT_LINE_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "client/io/text_cursor.h"

namespace cagefit::client {

struct TextLine {
  // Moves to the next line that is neither blank nor a comment; false at the end of the text.
  bool Next(TextCursor* cursor);

  // Of the word at `column` (from 0), which must be there; `field` is what the format calls it.
  // INVALID_ARGUMENT for what is no finite number.
  absl::Status ReadDouble(size_t column, absl::string_view field, double* value) const;
  absl::Status ReadInt(size_t column, absl::string_view field, int64_t* value) const;

  // "line 7: FIELD is "..."; expected ..."
  absl::Status Wrong(absl::string_view field, absl::string_view value,
                     absl::string_view expected) const;
  // "line 7: " and the message of `status`.
  absl::Status Located(const absl::Status& status) const;

  int64_t number = 0;  // from 1
  absl::string_view text;
  std::vector<absl::string_view> words;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_TEXT_LINE_H_
