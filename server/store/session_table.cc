#include "server/store/session_table.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "core/base/status.h"
#include "core/codec/crc32c.h"

namespace cagefit::server {
namespace {

#define CAGEFIT_HEAD_COLUMNS \
  "control_vertices, triangles, epoch, next, fitted, rejected, skipped, last_fitted, bytes"

SessionHead ReadHead(const Query& row, int column) {
  SessionHead head;
  head.control_vertices = static_cast<int32_t>(row.Int(column));
  head.triangles = static_cast<int32_t>(row.Int(column + 1));
  head.epoch = static_cast<uint64_t>(row.Int(column + 2));
  head.next_sequence_number = static_cast<uint64_t>(row.Int(column + 3));
  head.fitted_frames = static_cast<uint64_t>(row.Int(column + 4));
  head.rejected_frames = static_cast<uint64_t>(row.Int(column + 5));
  head.skipped_frames = static_cast<uint64_t>(row.Int(column + 6));
  if (!row.IsNull(column + 7)) head.last_fitted = static_cast<uint64_t>(row.Int(column + 7));
  head.stored_bytes = row.Int(column + 8);
  return head;
}

void BindWithChecksum(absl::string_view bytes, Query* query) {
  query->BindBlob(bytes).Bind(static_cast<int64_t>(Crc32c(bytes)));
}

absl::StatusOr<std::vector<std::string>> FirstColumn(Query* query) {
  std::vector<std::string> texts;
  for (;;) {
    ASSIGN_OR_RETURN(const bool row, query->Next());
    if (!row) return texts;
    texts.emplace_back(query->Bytes(0));
  }
}

// Why a stream of that epoch may not write.
absl::Status Overtaken(Database* database, const std::string& id, uint64_t epoch) {
  ASSIGN_OR_RETURN(Query query, Query::Make(database, "SELECT epoch FROM session WHERE id = ?"));
  ASSIGN_OR_RETURN(const bool found, query.Bind(absl::string_view(id)).Next());
  if (!found) return SessionDeleted(id);
  const uint64_t current = static_cast<uint64_t>(query.Int(0));
  if (current != epoch) return EpochSuperseded(epoch, current);
  // An answer is there whose commit seemed to fail. Who opens the session again finds it.
  return StoreUnavailable("the session has moved on; open it again");
}

absl::Status WriteTemplate(Database* database, int64_t session, absl::string_view mesh) {
  ASSIGN_OR_RETURN(
      Query query,
      Query::Make(database, "UPDATE session SET template = ?, template_crc = ? WHERE key = ?"));
  BindWithChecksum(mesh, &query);
  return query.Bind(session).Run();
}

// Whether the session was still at `before`, of `epoch`: other servers may write to it, too.
absl::StatusOr<bool> WriteHead(Database* database, int64_t session, uint64_t epoch, uint64_t before,
                               const SessionHead& head) {
  ASSIGN_OR_RETURN(
      Query query,
      Query::Make(database,
                  "UPDATE session SET control_vertices = ?, triangles = ?, next = ?, fitted = ?, "
                  "rejected = ?, skipped = ?, last_fitted = ?, bytes = ?, used = ?, begun = 0 "
                  "WHERE key = ? AND epoch = ? AND next = ? RETURNING key"));
  query.Bind(static_cast<int64_t>(head.control_vertices))
      .Bind(static_cast<int64_t>(head.triangles))
      .Bind(static_cast<int64_t>(head.next_sequence_number))
      .Bind(static_cast<int64_t>(head.fitted_frames))
      .Bind(static_cast<int64_t>(head.rejected_frames))
      .Bind(static_cast<int64_t>(head.skipped_frames));
  if (head.last_fitted.has_value()) {
    query.Bind(static_cast<int64_t>(*head.last_fitted));
  } else {
    query.BindNull();
  }
  query.Bind(head.stored_bytes)
      .Bind(absl::ToUnixNanos(absl::Now()))
      .Bind(session)
      .Bind(static_cast<int64_t>(epoch))
      .Bind(static_cast<int64_t>(before));
  ASSIGN_OR_RETURN(const bool written, query.Next());
  RETURN_IF_ERROR(query.Run());
  return written;
}

}  // namespace

absl::StatusOr<std::string> CheckedBytes(const Query& row, int column, absl::string_view what,
                                         const std::string& id) {
  const absl::string_view bytes = row.Bytes(column);
  if (static_cast<int64_t>(Crc32c(bytes)) == row.Int(column + 1)) return std::string(bytes);
  return absl::DataLossError(
      absl::StrCat("the stored ", what, " of session ", id, " is damaged: its checksum is wrong"));
}

absl::Status InsertSession(Database* database, const std::string& id, const SessionRow& row,
                           const std::optional<std::string>& mesh) {
  ASSIGN_OR_RETURN(
      Query query,
      Query::Make(database,
                  "INSERT INTO session (id, owner, created, used, config, config_crc, template, "
                  "template_crc, " CAGEFIT_HEAD_COLUMNS
                  ", begun) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, 0, 0, 0, 0, 0, NULL, 0, 0)"));
  query.Bind(absl::string_view(id))
      .Bind(absl::string_view(row.owner))
      .Bind(absl::ToUnixNanos(row.created))
      .Bind(absl::ToUnixNanos(row.created));
  BindWithChecksum(row.config, &query);
  if (mesh.has_value()) {
    BindWithChecksum(*mesh, &query);
  } else {
    query.BindNull().BindNull();
  }
  return query.Bind(static_cast<int64_t>(row.head.control_vertices))
      .Bind(static_cast<int64_t>(row.head.triangles))
      .Run();
}

absl::StatusOr<SessionRow> ReadSession(Database* database, const std::string& id) {
  ASSIGN_OR_RETURN(
      Query query,
      Query::Make(database, "SELECT owner, created, config, config_crc, " CAGEFIT_HEAD_COLUMNS
                            " FROM session WHERE id = ?"));
  ASSIGN_OR_RETURN(const bool found, query.Bind(absl::string_view(id)).Next());
  if (!found) return NoSession(id);
  SessionRow row;
  row.owner = std::string(query.Bytes(0));
  row.created = absl::FromUnixNanos(query.Int(1));
  ASSIGN_OR_RETURN(row.config, CheckedBytes(query, 2, "configuration", id));
  row.head = ReadHead(query, 4);
  return row;
}

absl::StatusOr<std::optional<std::string>> ReadTemplate(Database* database, const std::string& id) {
  ASSIGN_OR_RETURN(
      Query query,
      Query::Make(database, "SELECT template, template_crc FROM session WHERE id = ?"));
  ASSIGN_OR_RETURN(const bool found, query.Bind(absl::string_view(id)).Next());
  if (!found) return NoSession(id);
  if (query.IsNull(0)) return std::optional<std::string>();
  ASSIGN_OR_RETURN(std::string mesh, CheckedBytes(query, 0, "template", id));
  return std::optional<std::string>(std::move(mesh));
}

absl::StatusOr<std::vector<std::string>> IdsAfter(Database* database, const std::string& owner,
                                                  const std::string& after, size_t count) {
  ASSIGN_OR_RETURN(
      Query query,
      Query::Make(database,
                  "SELECT id FROM session WHERE owner = ? AND id > ? ORDER BY id LIMIT ?"));
  query.Bind(absl::string_view(owner))
      .Bind(absl::string_view(after))
      .Bind(static_cast<int64_t>(count));
  return FirstColumn(&query);
}

absl::StatusOr<int64_t> CountOfOwner(Database* database, const std::string& owner) {
  ASSIGN_OR_RETURN(Query query,
                   Query::Make(database, "SELECT count(*) FROM session WHERE owner = ?"));
  RETURN_IF_ERROR(query.Bind(absl::string_view(owner)).Next().status());
  return query.Int(0);
}

absl::StatusOr<std::vector<std::string>> IdsUsedBefore(Database* database, absl::Time time,
                                                       size_t count) {
  ASSIGN_OR_RETURN(
      Query query,
      Query::Make(database, "SELECT id FROM session WHERE used < ? ORDER BY used LIMIT ?"));
  query.Bind(absl::ToUnixNanos(time)).Bind(static_cast<int64_t>(count));
  return FirstColumn(&query);
}

absl::Status DeleteSession(Database* database, const std::string& id) {
  ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(database));
  // The session first: a stream that appends to it is done then, or will not find it.
  ASSIGN_OR_RETURN(Query session,
                   Query::Make(database, "DELETE FROM session WHERE id = ? RETURNING key"));
  ASSIGN_OR_RETURN(const bool found, session.Bind(absl::string_view(id)).Next());
  if (!found) return NoSession(id);
  const int64_t key = session.Int(0);
  RETURN_IF_ERROR(session.Run());
  ASSIGN_OR_RETURN(Query frames, Query::Make(database, "DELETE FROM frame WHERE session = ?"));
  RETURN_IF_ERROR(frames.Bind(key).Run());
  return transaction.Commit();
}

absl::StatusOr<int64_t> KeyOf(Database* database, const std::string& id) {
  ASSIGN_OR_RETURN(Query query, Query::Make(database, "SELECT key FROM session WHERE id = ?"));
  ASSIGN_OR_RETURN(const bool found, query.Bind(absl::string_view(id)).Next());
  if (!found) return NoSession(id);
  return query.Int(0);
}

absl::StatusOr<SessionHead> RaiseEpoch(Database* database, const std::string& id) {
  ASSIGN_OR_RETURN(Query query,
                   Query::Make(database,
                               "UPDATE session SET epoch = epoch + 1, used = ? WHERE id = ? "
                               "RETURNING " CAGEFIT_HEAD_COLUMNS));
  query.Bind(absl::ToUnixNanos(absl::Now())).Bind(absl::string_view(id));
  ASSIGN_OR_RETURN(const bool found, query.Next());
  if (!found) return NoSession(id);
  const SessionHead head = ReadHead(query, 0);
  RETURN_IF_ERROR(query.Run());  // commits
  return head;
}

absl::StatusOr<int> BeginFrame(Database* database, const std::string& id, uint64_t epoch) {
  ASSIGN_OR_RETURN(Query query, Query::Make(database,
                                            "UPDATE session SET begun = begun + 1 "
                                            "WHERE id = ? AND epoch = ? RETURNING begun"));
  query.Bind(absl::string_view(id)).Bind(static_cast<int64_t>(epoch));
  ASSIGN_OR_RETURN(const bool found, query.Next());
  if (!found) return Overtaken(database, id, epoch);
  const int begun = static_cast<int>(query.Int(0));
  RETURN_IF_ERROR(query.Run());  // commits
  return begun;
}

absl::Status AbandonFrame(Database* database, const std::string& id, uint64_t sequence_number) {
  ASSIGN_OR_RETURN(Query query,
                   Query::Make(database,
                               "UPDATE session "
                               "SET begun = CASE WHEN begun > 0 THEN begun - 1 ELSE 0 END "
                               "WHERE id = ? AND next = ?"));
  return query.Bind(absl::string_view(id)).Bind(static_cast<int64_t>(sequence_number)).Run();
}

absl::Status TouchSession(Database* database, const std::string& id, absl::Time now) {
  ASSIGN_OR_RETURN(Query query, Query::Make(database, "UPDATE session SET used = ? WHERE id = ?"));
  return query.Bind(absl::ToUnixNanos(now)).Bind(absl::string_view(id)).Run();
}

absl::StatusOr<int64_t> AdvanceSession(Database* database, const std::string& id, uint64_t epoch,
                                       const StoredFrame& frame, const ControlMesh* made_template,
                                       absl::string_view mesh) {
  ASSIGN_OR_RETURN(Query query,
                   Query::Make(database, "SELECT key, " CAGEFIT_HEAD_COLUMNS
                                         " FROM session WHERE id = ? AND epoch = ? AND next = ?"));
  query.Bind(absl::string_view(id))
      .Bind(static_cast<int64_t>(epoch))
      .Bind(static_cast<int64_t>(frame.sequence_number));
  ASSIGN_OR_RETURN(const bool found, query.Next());
  if (!found) return Overtaken(database, id, epoch);
  const int64_t key = query.Int(0);
  ASSIGN_OR_RETURN(const bool written, WriteHead(database, key, epoch, frame.sequence_number,
                                                 After(ReadHead(query, 1), frame, made_template)));
  if (!written) return Overtaken(database, id, epoch);
  if (made_template != nullptr) RETURN_IF_ERROR(WriteTemplate(database, key, mesh));
  return key;
}

}  // namespace cagefit::server
