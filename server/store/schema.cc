#include "server/store/schema.h"

#include <cstdint>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

// Times are nanoseconds since 1970. `begun`: fits of frame `next` without an answer. Records carry
// the CRC-32C of their bytes. The index has everything that opening a session reads of its answers
// but for a few deltas.
constexpr char kVersion1[] = R"(
CREATE TABLE session (
  key {key},
  id {text} NOT NULL UNIQUE,
  owner {text} NOT NULL,
  created {integer} NOT NULL,
  used {integer} NOT NULL,
  config {blob} NOT NULL,
  config_crc {integer} NOT NULL,
  template {blob},
  template_crc {integer},
  control_vertices {integer} NOT NULL,
  triangles {integer} NOT NULL,
  epoch {integer} NOT NULL,
  next {integer} NOT NULL,
  fitted {integer} NOT NULL,
  rejected {integer} NOT NULL,
  skipped {integer} NOT NULL,
  last_fitted {integer},
  bytes {integer} NOT NULL,
  begun {integer} NOT NULL
) {table_end};
CREATE INDEX session_used ON session (used);
CREATE INDEX session_owner ON session (owner, id);
CREATE TABLE frame (
  session {integer} NOT NULL,
  number {integer} NOT NULL,
  outcome {integer} NOT NULL,
  verdict {integer} NOT NULL,
  is_key {integer} NOT NULL,
  rms {real} NOT NULL,
  bare_share {real} NOT NULL,
  record {blob} NOT NULL,
  record_crc {integer} NOT NULL
) {table_end};
CREATE INDEX frame_outline ON frame (session, number, outcome, verdict, is_key, rms, bare_share);
CREATE TABLE probe (key {integer} PRIMARY KEY, bytes {blob} NOT NULL) {table_end};
)";

std::string Spell(const std::string& step, const SqlDialect& dialect) {
  return absl::StrReplaceAll(step, {{"{key}", dialect.key},
                                    {"{integer}", dialect.integer},
                                    {"{real}", dialect.real},
                                    {"{text}", dialect.text},
                                    {"{blob}", dialect.blob},
                                    {"{table_end}", dialect.table_end}});
}

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
    ASSIGN_OR_RETURN(const int64_t version, database->SchemaVersion());
    if (version > current) {
      return absl::FailedPreconditionError(absl::StrCat("the store has version ", version,
                                                        "; this server knows versions up to ",
                                                        current, "; use a newer one"));
    }
    if (version == current) return absl::OkStatus();
    RETURN_IF_ERROR(database->Execute(Spell(steps[version], database->dialect())));
    RETURN_IF_ERROR(database->SetSchemaVersion(version + 1));
    RETURN_IF_ERROR(transaction.Commit());
  }
}

}  // namespace cagefit::server
