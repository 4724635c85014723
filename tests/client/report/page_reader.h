// Reads what a report page was given, written from payload.h's description alone.
#ifndef CAGEFIT_TESTS_CLIENT_REPORT_PAGE_READER_H_
#define CAGEFIT_TESTS_CLIENT_REPORT_PAGE_READER_H_

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace cagefit::testing {

struct PageData {
  nlohmann::json header;
  std::map<std::string, std::vector<uint32_t>> arrays;
};

// Throws std::runtime_error where the text is not as described.
PageData ReadPayload(const std::string& text);

struct ReportPage {
  std::string data;   // the text of the payload
  std::string shell;  // the page without it
};
ReportPage SplitPage(const std::string& html);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CLIENT_REPORT_PAGE_READER_H_
