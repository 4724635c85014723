// Manual pages of programs, from their options.
#ifndef CAGEFIT_DEPLOY_MANUAL_MAN_PAGE_H_
#define CAGEFIT_DEPLOY_MANUAL_MAN_PAGE_H_

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace cagefit::manual {

struct Page {
  std::string name;  // "cagefit-fit"
  int section = 1;
  std::string text;  // roff with the man macros [man(7)]
};

// One page for the program, and one for each subcommand that does something.
std::vector<Page> ManPages(const CLI::App& app, int section, const std::string& version);

}  // namespace cagefit::manual

#endif  // CAGEFIT_DEPLOY_MANUAL_MAN_PAGE_H_
