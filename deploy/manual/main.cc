// Writes manual pages and completion scripts of cagefit and cagefitd:
//   cagefit_manual FOLDER      FOLDER/man/man1/cagefit.1 and so on,
//   FOLDER/bash-completion/completions/cagefit and so on
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>

#include "absl/strings/str_cat.h"
#include "client/commands/parse.h"
#include "deploy/manual/bash_completion.h"
#include "deploy/manual/man_page.h"
#include "server/server_options.h"

namespace cagefit::manual {
namespace {

bool Write(const std::string& path, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream file(path);
  file << text;
  file.close();
  if (file.good()) return true;
  std::cerr << "cagefit_manual: " << path << ": cannot be written\n";
  return false;
}

bool WriteManual(const CLI::App& app, int section, const std::string& folder) {
  bool ok = Write(absl::StrCat(folder, "/bash-completion/completions/", app.get_name()),
                  BashCompletion(app));
  for (const Page& page : ManPages(app, section, "cagefit " CAGEFIT_VERSION)) {
    ok &= Write(absl::StrCat(folder, "/man/man", section, "/", page.name, ".", section), page.text);
  }
  return ok;
}

}  // namespace
}  // namespace cagefit::manual

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: cagefit_manual FOLDER\n";
    return 2;
  }
  cagefit::client::Run run;
  std::vector<std::string> words;
  const std::unique_ptr<CLI::App> client = cagefit::client::MakeApp(&words, &run);
  cagefit::server::ServerOptions options;
  const std::unique_ptr<CLI::App> server = cagefit::server::MakeApp(&options);
  const bool ok = cagefit::manual::WriteManual(*client, 1, argv[1]) &&
                  cagefit::manual::WriteManual(*server, 8, argv[1]);
  return ok ? 0 : 1;
}
