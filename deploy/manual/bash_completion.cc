#include "deploy/manual/bash_completion.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "deploy/manual/options.h"

namespace cagefit::manual {
namespace {

// Cases of the command, spelt by its words, and of those below it.
void AddCases(const CLI::App& app, const std::string& command, std::string* words,
              std::string* values) {
  std::vector<std::string> next;
  for (const CLI::App* sub : app.get_subcommands({})) {
    next.push_back(sub->get_name());
    AddCases(*sub, absl::StrCat(command, " ", sub->get_name()), words, values);
  }
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_positional()) continue;
    const std::vector<std::string> names = NamesOf(*option);
    next.insert(next.end(), names.begin(), names.end());
    if (!TakesValue(*option)) continue;
    for (const std::string& name : names) {
      absl::StrAppend(values, "    '", command, " ", name, "') echo '",
                      absl::StrJoin(ChoicesOf(*option), " "), "' ;;\n");
    }
  }
  absl::StrAppend(words, "    '", command, "') echo '", absl::StrJoin(next, " "), "' ;;\n");
}

}  // namespace

std::string BashCompletion(const CLI::App& app) {
  const std::string name = app.get_name();
  std::string words, values;
  AddCases(app, name, &words, &values);
  return absl::StrCat(
      "# Completion of ", name, " for bash.\n\n",
      "# What may follow the command of these words.\n_", name, "_words() {\n  case $1 in\n", words,
      "    *) return 1 ;;\n  esac\n}\n\n",
      "# What the last word, an option, takes: one of a list, or names of files where that is "
      "empty.\n_",
      name, "_values() {\n  case $1 in\n", values, "    *) return 1 ;;\n  esac\n}\n\n_", name,
      "() {\n  local command=", name,
      " word choices k\n"
      "  for ((k = 1; k < COMP_CWORD; ++k)); do\n"
      "    word=\"$command ${COMP_WORDS[k]}\"\n"
      "    _",
      name,
      "_words \"$word\" >/dev/null && command=$word\n"
      "  done\n"
      "  word=${COMP_WORDS[COMP_CWORD]}\n"
      "  if choices=$(_",
      name,
      "_values \"$command ${COMP_WORDS[COMP_CWORD - 1]}\"); then\n"
      "    COMPREPLY=($(compgen -W \"$choices\" -- \"$word\"))\n"
      "  elif [[ $word == -* || $(_",
      name, "_words \"$command\") != -* ]]; then\n    COMPREPLY=($(compgen -W \"$(_", name,
      "_words \"$command\")\" -- \"$word\"))\n  else\n    COMPREPLY=()\n  fi\n}\n"
      "complete -o default -F _",
      name, " ", name, "\n");
}

}  // namespace cagefit::manual
