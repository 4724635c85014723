// A fit as a page for people: one file that any current browser opens, without a network.
#ifndef CAGEFIT_CLIENT_REPORT_HTML_REPORT_H_
#define CAGEFIT_CLIENT_REPORT_HTML_REPORT_H_

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "client/report/scene.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::client {

struct HtmlReport {
  nlohmann::ordered_json report;      // report.json: the page's numbers, its table and its curves
  const ControlMesh* cage = nullptr;  // connectivity of all frames; null: none was fitted
  std::vector<ReportFrame> frames;    // ascending
  double frames_per_second = 24;      // at which the page plays them
  char up_axis = 'Y';                 // or 'Z'
};

// Reads the targets of the frames again, those that the page shows in 3D. What cannot be read is
// shown without a target. Whole or not at all: written beside and renamed; errors of the file.
absl::Status WriteHtmlReport(const std::string& path, const HtmlReport& report);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_REPORT_HTML_REPORT_H_
