#include "server/server_options_print.h"

#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "server/server_options_file.h"

namespace cagefit::server {
namespace {

std::vector<std::string> DefaultsOf(const CLI::Option& option) {
  const std::string text = option.get_default_str();
  if (text.empty()) return {};
  const bool list = option.get_items_expected_max() > 1;
  if (!list || !absl::StartsWith(text, "[") || !absl::EndsWith(text, "]")) return {text};
  return absl::StrSplit(text.substr(1, text.size() - 2), ',', absl::SkipEmpty());
}

}  // namespace

std::string SettingsText(const CLI::App& app, const CommandLine& line) {
  std::string text;
  for (const CLI::Option* option : app.get_options()) {
    if (!IsSetting(*option)) continue;
    const std::string name = option->get_single_name();
    const auto source = line.sources.find("--" + name);
    // A path in a source must not end the comment.
    absl::StrAppend(&text, "# ",
                    option->count() == 0 ? "default"
                    : source == line.sources.end()
                        ? "flag"
                        : absl::StrReplaceAll(source->second, {{"\n", " "}}),
                    "\n");
    const std::vector<std::string> values =
        option->count() == 0 ? DefaultsOf(*option) : option->results();
    if (values.empty()) absl::StrAppend(&text, "# ", name, "=\n");
    for (const std::string& value : values) {
      absl::StrAppend(&text, SettingLine(name, value), "\n");
    }
  }
  return text;
}

}  // namespace cagefit::server
