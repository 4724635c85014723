#include "client/commands/parse.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "client/commands/command.h"

namespace cagefit::client {
namespace {

// The subcommand that the first words name, as deep as they go.
const CLI::App* Named(const CLI::App* app, const std::vector<std::string>& arguments) {
  for (const std::string& argument : arguments) {
    const CLI::App* next = nullptr;
    for (const CLI::App* sub : app->get_subcommands({})) {
      if (sub->get_name() == argument) next = sub;
    }
    if (next == nullptr) break;
    app = next;
  }
  return app;
}

bool IsGiven(const std::vector<std::string>& arguments, const std::string& flag) {
  return std::any_of(arguments.begin(), arguments.end(), [&](const std::string& argument) {
    return argument.substr(0, argument.find('=')) == flag;
  });
}

// Variables such as CAGEFIT_FAR_RADIUS become flags of the subcommand, unless these are given:
// CLI11 itself would let a file overrule a variable.
void AddVariables(const CLI::App& command, std::vector<std::string>* arguments) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    const std::string flag = "--" + name;
    const char* value = std::getenv(
        absl::StrCat("CAGEFIT_", absl::AsciiStrToUpper(absl::StrReplaceAll(name, {{"-", "_"}})))
            .c_str());
    if (value == nullptr || flag == "--help" || IsGiven(*arguments, flag)) continue;
    arguments->push_back(absl::StrCat(flag, "=", value));
  }
}

// The lines of the file that --config names, the same way. Throws CLI::ParseError.
void AddFile(const CLI::App& command, std::vector<std::string>* arguments) {
  std::string path;
  for (size_t k = 0; k < arguments->size(); ++k) {
    const std::string& argument = (*arguments)[k];
    if (argument == "--config" && k + 1 < arguments->size()) path = (*arguments)[k + 1];
    if (absl::StartsWith(argument, "--config=")) path = argument.substr(sizeof("--config=") - 1);
  }
  if (path.empty()) return;
  for (const CLI::ConfigItem& item : CLI::ConfigINI().from_file(path)) {
    const std::string flag = "--" + item.name;
    if (!item.parents.empty() || command.get_option_no_throw(flag) == nullptr) {
      throw CLI::ConfigError(absl::StrCat(path, ": no option of ", command.get_name(),
                                          " is called ", item.fullname()));
    }
    if (IsGiven(*arguments, flag)) continue;
    for (const std::string& value : item.inputs) {
      arguments->push_back(absl::StrCat(flag, "=", value));
    }
  }
}

}  // namespace

std::unique_ptr<CLI::App> MakeApp(const std::vector<std::string>* words, Run* run) {
  auto app = std::make_unique<CLI::App>("Fits subdivision surfaces to captures of moving things.",
                                        "cagefit");
  app->set_version_flag("--version", "cagefit " CAGEFIT_VERSION);
  app->require_subcommand(1);
  app->footer(
      "`cagefit COMMAND --help` explains a command. Its options are also read from CAGEFIT_NAME, "
      "as "
      "in CAGEFIT_SERVER.\nExit codes: 0 done, 1 the work failed, 2 wrong usage, 3 no server, 4 "
      "partly done.");
  AddFitCommand(app.get(), words, run);
  AddTemplateCommand(app.get(), run);
  AddTokenCommand(app.get(), run);
  AddRefineCommand(app.get(), run);
  AddRenderCommand(app.get(), run);
  AddEvaluateCommand(app.get(), run);
  AddSessionCommand(app.get(), run);
  AddSynthCommand(app.get(), run);
  AddHealthCommand(app.get(), run);
  return app;
}

int RunCommandLine(int argc, const char* const* argv) {
  Run run;
  std::vector<std::string> words = {argv[0]};
  const std::unique_ptr<CLI::App> app = MakeApp(&words, &run);
  std::vector<std::string> arguments(argv + 1, argv + argc);
  const CLI::App* command = Named(app.get(), arguments);
  try {
    AddVariables(*command, &arguments);
    words.insert(words.end(), arguments.begin(), arguments.end());
    AddFile(*command, &arguments);
    std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
    app->parse(std::move(arguments));
  } catch (const CLI::Success& success) {
    return app->exit(success);
  } catch (const CLI::ParseError& error) {
    const std::string name = command == app.get() ? "" : " " + command->get_name();
    std::cerr << "cagefit: " << error.what() << "\nRun cagefit" << name
              << " --help for its options.\n";
    return kWrongUsage;
  } catch (const std::invalid_argument&) {  // CLI11's own, without a name
    std::cerr << "cagefit: a switch was given a value that is neither true nor false\n";
    return kWrongUsage;
  }
  return run();
}

}  // namespace cagefit::client
