#include "tests/soak/event_line.h"

#include <vector>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace cagefit::testing {

// The last word is always the same, so that the beginning of a line is not taken for one.
constexpr char kEnd[] = ".";

std::string LineOf(const History::Event& event) {
  return absl::StrCat(static_cast<int>(event.kind), " ", event.number, " ", event.epoch, " ",
                      absl::BytesToHexString(event.bits), " ", kEnd);
}

std::optional<History::Event> EventOf(const std::string& line) {
  const std::vector<std::string> words = absl::StrSplit(line, ' ');
  History::Event event;
  int kind = 0;
  if (words.size() != 5 || words[4] != kEnd || !absl::SimpleAtoi(words[0], &kind) ||
      !absl::SimpleAtoi(words[1], &event.number) || !absl::SimpleAtoi(words[2], &event.epoch)) {
    return std::nullopt;
  }
  event.kind = static_cast<History::Event::Kind>(kind);
  event.bits = absl::HexStringToBytes(words[3]);
  return event;
}

}  // namespace cagefit::testing
