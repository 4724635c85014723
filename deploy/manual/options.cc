#include "deploy/manual/options.h"

#include "absl/strings/str_split.h"

namespace cagefit::manual {

std::vector<std::string> NamesOf(const CLI::Option& option) {
  if (option.get_positional()) return {option.get_name(/*positional=*/true)};
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

bool TakesValue(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

std::string ValueName(const CLI::Option& option) {
  const std::string name = option.get_type_name();  // "TEXT:{a,b}", "FLOAT:FLOAT in [0 - 1]"
  return name.substr(0, name.find(':'));
}

std::vector<std::string> ChoicesOf(const CLI::Option& option) {
  const std::string name = option.get_type_name();
  const size_t open = name.find('{'), close = name.find('}');
  if (open == std::string::npos || close == std::string::npos) return {};
  return absl::StrSplit(name.substr(open + 1, close - open - 1), ',');
}

}  // namespace cagefit::manual
