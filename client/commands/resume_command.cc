#include "client/commands/resume_command.h"

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/string_view.h"

namespace cagefit::client {
namespace {

bool IsPlain(absl::string_view word) {
  constexpr absl::string_view kPlain = "_-./:=,+@%";
  for (const char c : word) {
    if (!absl::ascii_isalnum(c) && kPlain.find(c) == absl::string_view::npos) return false;
  }
  return !word.empty();
}

}  // namespace

std::string ShellQuoted(const std::string& word) {
  if (IsPlain(word)) return word;
  return absl::StrCat("'", absl::StrReplaceAll(word, {{"'", "'\\''"}}), "'");
}

std::string CommandWith(const std::vector<std::string>& words, const std::string& flag,
                        const std::string& value) {
  std::vector<std::string> kept;
  for (size_t k = 0; k < words.size(); ++k) {
    if (words[k] == flag) {
      ++k;  // its value
    } else if (!absl::StartsWith(words[k], flag + "=")) {
      kept.push_back(words[k]);
    }
  }
  kept.push_back(flag);
  kept.push_back(value);
  return Command(kept);
}

std::string Command(const std::vector<std::string>& words) {
  return absl::StrJoin(words, " ", [](std::string* out, const std::string& word) {
    out->append(ShellQuoted(word));
  });
}

}  // namespace cagefit::client
