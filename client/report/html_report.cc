#include "client/report/html_report.h"

#include "absl/strings/str_cat.h"
#include "client/io/file_bytes.h"
#include "client/report/page_files.h"
#include "client/report/payload.h"
#include "client/report/scene_payload.h"

namespace cagefit::client {
namespace {

constexpr absl::string_view kOpen = "{{", kClose = "}}";

// page.html with the file NAME for each {{NAME}}, and `data` for {{data}}.
std::string FillPage(absl::string_view data) {
  std::string page;
  absl::string_view rest = PageFile("page.html");
  while (true) {
    const size_t open = rest.find(kOpen), close = rest.find(kClose);
    if (open == absl::string_view::npos) break;
    const absl::string_view name = rest.substr(open + kOpen.size(), close - open - kOpen.size());
    absl::StrAppend(&page, rest.substr(0, open), name == "data" ? data : PageFile(name));
    rest.remove_prefix(close + kClose.size());
  }
  absl::StrAppend(&page, rest);
  return page;
}

}  // namespace

absl::Status WriteHtmlReport(const std::string& path, const HtmlReport& report) {
  Payload payload;
  nlohmann::ordered_json header = {{"report", report.report},
                                   {"frames_per_second", report.frames_per_second},
                                   {"up_axis", std::string(1, report.up_axis)}};
  if (report.cage != nullptr) {
    const Scene scene = BuildScene(*report.cage, report.frames);
    header["scene"] = AddScene(scene, *report.cage, &payload);
  }
  return WriteFileBytes(path, FillPage(payload.Encode(std::move(header))));
}

}  // namespace cagefit::client
