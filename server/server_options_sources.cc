#include "server/server_options_sources.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "core/base/status.h"
#include "server/server_options_file.h"
#include "server/server_options_suggestion.h"

namespace cagefit::server {
namespace {

constexpr char kVariablePrefix[] = "CAGEFITD_";

std::string VariableOf(const std::string& name) {
  return kVariablePrefix + absl::AsciiStrToUpper(absl::StrReplaceAll(name, {{"-", "_"}}));
}

std::string NameOf(absl::string_view variable) {
  return absl::StrReplaceAll(absl::AsciiStrToLower(variable.substr(sizeof(kVariablePrefix) - 1)),
                             {{"_", "-"}});
}

std::vector<std::string> NamesOf(const CLI::App& app,
                                 const std::function<bool(const CLI::Option&)>& wanted) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    if (wanted(*option)) names.push_back(option->get_single_name());
  }
  return names;
}

bool IsList(const CLI::Option& option) { return option.get_items_expected_max() > 1; }

void AddArgument(const std::string& flag, const std::string& value,
                 std::vector<std::string>* arguments) {
  // CLI11 takes the next argument for the value behind "--flag=".
  if (value.empty()) {
    arguments->insert(arguments->end(), {flag, value});
  } else {
    arguments->push_back(absl::StrCat(flag, "=", value));
  }
}

// Of the environment too: what is told by --help, --version or --print-config is asked for by flag.
bool MayBeVariable(const CLI::Option& option) {
  return IsSetting(option) || option.get_single_name() == "config";
}

}  // namespace

CommandLine::CommandLine(std::vector<std::string> given) : arguments(std::move(given)) {
  for (const std::string& argument : arguments) {
    if (absl::StartsWith(argument, "--")) sources[argument.substr(0, argument.find('='))] = "flag";
  }
}

bool IsSetting(const CLI::Option& option) {
  const std::string& name = option.get_single_name();
  return name != "help" && name != "version" && name != "config" && name != "print-config";
}

absl::Status AddEnvironment(const CLI::App& app, CommandLine* line) {
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!absl::StartsWith(*entry, kVariablePrefix)) continue;
    const std::pair<std::string, std::string> variable =
        absl::StrSplit(*entry, absl::MaxSplits('=', 1));
    const std::string flag = "--" + NameOf(variable.first);
    const CLI::Option* option = app.get_option_no_throw(flag);
    if (option == nullptr || !MayBeVariable(*option)) {
      std::vector<std::string> names = NamesOf(app, MayBeVariable);
      for (std::string& name : names) name = VariableOf(name);
      return absl::InvalidArgumentError(
          absl::StrCat("no setting is called ", variable.first, Suggestion(variable.first, names)));
    }
    if (!line->sources.emplace(flag, "variable " + variable.first).second) continue;
    for (const absl::string_view value :
         absl::StrSplit(variable.second, absl::MaxSplits(',', IsList(*option) ? 1000 : 0))) {
      AddArgument(flag, std::string(value), &line->arguments);
    }
  }
  return absl::OkStatus();
}

absl::Status AddFile(const CLI::App& app, CommandLine* line) {
  std::string path;
  for (size_t k = 0; k < line->arguments.size(); ++k) {
    const std::string& argument = line->arguments[k];
    if (argument == "--config" && k + 1 < line->arguments.size()) path = line->arguments[k + 1];
    if (absl::StartsWith(argument, "--config=")) path = argument.substr(sizeof("--config=") - 1);
  }
  if (path.empty()) return absl::OkStatus();
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file.is_open() || text.bad() || std::filesystem::is_directory(path)) {
    return absl::NotFoundError(absl::StrCat("--config is ", path, ", which cannot be read"));
  }
  auto settings = ParseSettings(text.str());
  if (!settings.ok()) {
    return absl::InvalidArgumentError(absl::StrCat(path, ", ", settings.status().message()));
  }
  const std::map<std::string, std::string> counts_more = line->sources;
  for (const FileSetting& setting : *settings) {
    const std::string flag = "--" + setting.name;
    const CLI::Option* option = app.get_option_no_throw(flag);
    if (option == nullptr || !IsSetting(*option)) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ", line ", setting.line, ": no setting is called ", setting.name,
                       Suggestion(setting.name, NamesOf(app, IsSetting))));
    }
    const std::string source = absl::StrCat(path, ", line ", setting.line);
    if (counts_more.count(flag) > 0) continue;
    if (!line->sources.emplace(flag, source).second && !IsList(*option)) {
      return absl::InvalidArgumentError(absl::StrCat(source, ": ", setting.name, " is set twice"));
    }
    AddArgument(flag, setting.value, &line->arguments);
  }
  return absl::OkStatus();
}

}  // namespace cagefit::server
