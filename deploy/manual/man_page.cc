#include "deploy/manual/man_page.h"

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "deploy/manual/options.h"

namespace cagefit::manual {
namespace {

// Text that roff takes as it is: no escapes, and no request at the start of a line.
std::string Plain(const std::string& text) {
  std::string escaped = absl::StrReplaceAll(text, {{"\\", "\\e"}, {"-", "\\-"}, {"`", "\\(ga"}});
  return escaped.empty() || (escaped[0] != '.' && escaped[0] != '\'') ? escaped : "\\&" + escaped;
}

std::string Bold(const std::string& text) { return absl::StrCat("\\fB", Plain(text), "\\fR"); }
std::string Italic(const std::string& text) { return absl::StrCat("\\fI", Plain(text), "\\fR"); }

// A paragraph for each line.
std::string Paragraphs(const std::string& text) {
  const std::vector<std::string> lines = absl::StrSplit(text, '\n', absl::SkipWhitespace());
  return absl::StrJoin(lines, ".PP\n", [](std::string* out, const std::string& line) {
    absl::StrAppend(out, Plain(line), "\n");
  });
}

std::string OptionText(const CLI::Option& option) {
  std::string names = absl::StrJoin(
      NamesOf(option), ", ", [](std::string* out, const auto& name) { out->append(Bold(name)); });
  if (TakesValue(option) && !option.get_positional()) {
    absl::StrAppend(&names, " ", Italic(ValueName(option)));
  }
  std::string text = Plain(option.get_description());
  const std::vector<std::string> choices = ChoicesOf(option);
  if (!choices.empty()) {
    absl::StrAppend(&text, " (", Plain(absl::StrJoin(choices, ", ")), ")");
  }
  if (!option.get_default_str().empty()) {
    absl::StrAppend(&text, " [", Plain(option.get_default_str()), "]");
  }
  return absl::StrCat(".TP\n", names, "\n", text, "\n");
}

std::string Synopsis(const CLI::App& app, const std::string& command) {
  std::string text = Bold(command);
  if (!app.get_subcommands({}).empty()) {
    return absl::StrCat(text, " ", Italic("COMMAND"), " [", Italic("OPTION"), "]...\n");
  }
  absl::StrAppend(&text, " [", Italic("OPTION"), "]...");
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_positional()) continue;
    const char* more = option->get_items_expected_max() > 1 ? "..." : "";
    absl::StrAppend(&text, " ", Italic(option->get_name(/*positional=*/true)), more);
  }
  return text + "\n";
}

std::string OptionSection(const CLI::App& app, bool positional, const char* title) {
  std::string text;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_positional() == positional) absl::StrAppend(&text, OptionText(*option));
  }
  return text.empty() ? "" : absl::StrCat(".SH ", title, "\n", text);
}

class Writer {
 public:
  Writer(int section, const std::string& version) : section_(section), version_(version) {}

  // `command`: the words that call it. `footer`: of the program.
  void Add(const CLI::App& app, const std::string& command, const std::string& footer) {
    const std::string name = absl::StrReplaceAll(command, {{" ", "-"}});
    std::string text =
        absl::StrCat(".TH ", absl::AsciiStrToUpper(name), " ", section_, " \"\" \"", version_,
                     "\"\n.SH NAME\n", Plain(name), " \\- ", Plain(app.get_description()),
                     "\n.SH SYNOPSIS\n", Synopsis(app, command));
    absl::StrAppend(&text, OptionSection(app, true, "ARGUMENTS"),
                    OptionSection(app, false, "OPTIONS"));
    const auto subcommands = app.get_subcommands({});
    if (!subcommands.empty()) text.append(".SH COMMANDS\n");
    for (const CLI::App* sub : subcommands) {
      const std::string sub_name = absl::StrCat(name, "-", sub->get_name());
      absl::StrAppend(&text, ".TP\n", Bold(sub_name), "(", section_, ")\n",
                      Plain(sub->get_description()), "\n");
    }
    if (!footer.empty()) absl::StrAppend(&text, ".SH NOTES\n", Paragraphs(footer));
    pages_.push_back({name, section_, std::move(text)});
    for (const CLI::App* sub : subcommands) {
      Add(*sub, absl::StrCat(command, " ", sub->get_name()), footer);
    }
  }

  std::vector<Page> pages() && { return std::move(pages_); }

 private:
  const int section_;
  const std::string version_;
  std::vector<Page> pages_;
};

}  // namespace

std::vector<Page> ManPages(const CLI::App& app, int section, const std::string& version) {
  Writer writer(section, version);
  writer.Add(app, app.get_name(), app.get_footer());
  return std::move(writer).pages();
}

}  // namespace cagefit::manual
