// The parts of a report page that are the same in every report: files that the build puts into the
// program.
#ifndef CAGEFIT_CLIENT_REPORT_PAGE_FILES_H_
#define CAGEFIT_CLIENT_REPORT_PAGE_FILES_H_

#include "absl/strings/string_view.h"

namespace cagefit::client {

// The bytes of a file in client/report/page/ or of one of three.js that is named there; empty for
// any other name.
absl::string_view PageFile(absl::string_view name);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_REPORT_PAGE_FILES_H_
