// Numbers as text.
#ifndef CAGEFIT_CLIENT_IO_NUMBER_TEXT_H_
#define CAGEFIT_CLIENT_IO_NUMBER_TEXT_H_

#include <charconv>
#include <string>

namespace cagefit::client {

// The shortest text that reads back to the same value.
template <typename Value>
void AppendNumber(Value value, std::string* text) {
  char digits[40];
  const auto [end, error] = std::to_chars(digits, digits + sizeof(digits), value);
  text->append(digits, end);
}

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_NUMBER_TEXT_H_
