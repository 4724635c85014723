// Rows of the sessions. Errors of all: StoreUnavailable, and as Journal says.
#ifndef CAGEFIT_SERVER_STORE_SESSION_TABLE_H_
#define CAGEFIT_SERVER_STORE_SESSION_TABLE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "server/session/journal.h"
#include "server/store/database.h"

namespace cagefit::server {

// A session without what a codec makes of it.
struct SessionRow {
  std::string owner;
  absl::Time created;
  std::string config;
  SessionHead head;
};

// The bytes of `row`'s blob in `column`, whose CRC-32C is in the next one. DATA_LOSS.
absl::StatusOr<std::string> CheckedBytes(const Query& row, int column, absl::string_view what,
                                         const std::string& id);

absl::Status InsertSession(Database* database, const std::string& id, const SessionRow& row,
                           const std::optional<std::string>& mesh);
absl::StatusOr<SessionRow> ReadSession(Database* database, const std::string& id);
absl::StatusOr<std::optional<std::string>> ReadTemplate(Database* database, const std::string& id);
absl::StatusOr<std::vector<std::string>> IdsAfter(Database* database, const std::string& owner,
                                                  const std::string& after, size_t count);
absl::StatusOr<int64_t> CountOfOwner(Database* database, const std::string& owner);
absl::StatusOr<std::vector<std::string>> IdsUsedBefore(Database* database, absl::Time time,
                                                       size_t count);
absl::Status DeleteSession(Database* database, const std::string& id);

absl::StatusOr<int64_t> KeyOf(Database* database, const std::string& id);
absl::StatusOr<SessionHead> RaiseEpoch(Database* database, const std::string& id);
absl::StatusOr<int> BeginFrame(Database* database, const std::string& id, uint64_t epoch);
absl::Status AbandonFrame(Database* database, const std::string& id, uint64_t sequence_number);
absl::Status TouchSession(Database* database, const std::string& id, absl::Time now);

// The session takes one more answer of `epoch` in; returns its key. `mesh`: of `made_template`,
// which may be null.
absl::StatusOr<int64_t> AdvanceSession(Database* database, const std::string& id, uint64_t epoch,
                                       const StoredFrame& frame, const ControlMesh* made_template,
                                       absl::string_view mesh);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_SESSION_TABLE_H_
