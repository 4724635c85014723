#include "server/store/schema.h"

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

constexpr int64_t kApplicationId = 0x43616765;  // "Cage"

// Times are nanoseconds since 1970. `begun`: fits of frame `next` without an answer. Records carry
// the CRC-32C of their bytes. The index has everything that opening a session reads of its answers
// but for a few deltas.
constexpr char kVersion1[] = R"(
CREATE TABLE session (
  key INTEGER PRIMARY KEY,
  id TEXT NOT NULL UNIQUE,
  owner TEXT NOT NULL,
  created INTEGER NOT NULL,
  used INTEGER NOT NULL,
  config BLOB NOT NULL,
  config_crc INTEGER NOT NULL,
  template BLOB,
  template_crc INTEGER,
  control_vertices INTEGER NOT NULL,
  triangles INTEGER NOT NULL,
  epoch INTEGER NOT NULL,
  next INTEGER NOT NULL,
  fitted INTEGER NOT NULL,
  rejected INTEGER NOT NULL,
  skipped INTEGER NOT NULL,
  last_fitted INTEGER,
  bytes INTEGER NOT NULL,
  begun INTEGER NOT NULL
) STRICT;
CREATE INDEX session_used ON session (used);
CREATE INDEX session_owner ON session (owner, id);
CREATE TABLE frame (
  session INTEGER NOT NULL,
  number INTEGER NOT NULL,
  outcome INTEGER NOT NULL,
  verdict INTEGER NOT NULL,
  is_key INTEGER NOT NULL,
  rms REAL NOT NULL,
  bare_share REAL NOT NULL,
  record BLOB NOT NULL,
  record_crc INTEGER NOT NULL
) STRICT;
CREATE INDEX frame_outline ON frame (session, number, outcome, verdict, is_key, rms, bare_share);
CREATE TABLE probe (key INTEGER PRIMARY KEY, bytes BLOB NOT NULL) STRICT;
)";

}  // namespace

const std::vector<std::string>& SchemaSteps() {
  static const std::vector<std::string>* const steps = new std::vector<std::string>{kVersion1};
  return *steps;
}

absl::Status Migrate(Database* database, const std::vector<std::string>& steps) {
  const int64_t current = static_cast<int64_t>(steps.size());
  for (;;) {
    // Under the lock, so that two servers do not take the same step.
    ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(database));
    ASSIGN_OR_RETURN(const int64_t application, database->Number("PRAGMA application_id"));
    ASSIGN_OR_RETURN(const int64_t tables, database->Number("SELECT count(*) FROM sqlite_schema"));
    if (tables > 0 && application != kApplicationId) {
      return absl::FailedPreconditionError("the store's file is a database of another program");
    }
    ASSIGN_OR_RETURN(const int64_t version, database->Number("PRAGMA user_version"));
    if (version > current) {
      return absl::FailedPreconditionError(absl::StrCat("the store has version ", version,
                                                        "; this server knows versions up to ",
                                                        current, "; use a newer one"));
    }
    if (version == current) return absl::OkStatus();
    RETURN_IF_ERROR(database->Execute(steps[version]));
    RETURN_IF_ERROR(database->Execute(absl::StrCat("PRAGMA user_version = ", version + 1,
                                                   "; PRAGMA application_id = ", kApplicationId)));
    RETURN_IF_ERROR(transaction.Commit());
  }
}

}  // namespace cagefit::server
