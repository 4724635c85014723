// Rows of the answers. Errors of all: StoreUnavailable, and as Journal says.
#ifndef CAGEFIT_SERVER_STORE_FRAME_TABLE_H_
#define CAGEFIT_SERVER_STORE_FRAME_TABLE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "server/session/journal.h"
#include "server/store/database.h"

namespace cagefit::server {

// `session` is its key in the session table.
absl::Status InsertFrame(Database* database, int64_t session, const FrameOutline& outline,
                         absl::string_view record);
// Nothing when that frame is not answered.
absl::StatusOr<std::optional<std::string>> ReadFrame(Database* database, const std::string& id,
                                                     uint64_t sequence_number);
absl::StatusOr<std::vector<FrameOutline>> ReadOutlines(Database* database, const std::string& id);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_FRAME_TABLE_H_
