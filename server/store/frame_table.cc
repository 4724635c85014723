#include "server/store/frame_table.h"

#include <utility>

#include "core/base/status.h"
#include "core/codec/crc32c.h"
#include "server/store/session_table.h"

namespace cagefit::server {

absl::Status InsertFrame(Database* database, int64_t session, const FrameOutline& outline,
                         absl::string_view record) {
  ASSIGN_OR_RETURN(Query query,
                   Query::Make(database, "INSERT INTO frame VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)"));
  return query.Bind(session)
      .Bind(static_cast<int64_t>(outline.sequence_number))
      .Bind(static_cast<int64_t>(outline.outcome))
      .Bind(static_cast<int64_t>(outline.verdict))
      .Bind(static_cast<int64_t>(outline.key))
      .Bind(outline.rms)
      .Bind(outline.bare_share)
      .BindBlob(record)
      .Bind(static_cast<int64_t>(Crc32c(record)))
      .Run();
}

absl::StatusOr<std::optional<std::string>> ReadFrame(Database* database, const std::string& id,
                                                     uint64_t sequence_number) {
  ASSIGN_OR_RETURN(const int64_t session, KeyOf(database, id));
  ASSIGN_OR_RETURN(Query query, Query::Make(database,
                                            "SELECT record, record_crc FROM frame "
                                            "WHERE session = ? AND number = ?"));
  query.Bind(session).Bind(static_cast<int64_t>(sequence_number));
  ASSIGN_OR_RETURN(const bool found, query.Next());
  if (!found) return std::optional<std::string>();
  ASSIGN_OR_RETURN(std::string record, CheckedBytes(query, 0, "answer", id));
  return std::optional<std::string>(std::move(record));
}

absl::StatusOr<std::vector<FrameOutline>> ReadOutlines(Database* database, const std::string& id) {
  ASSIGN_OR_RETURN(const int64_t session, KeyOf(database, id));
  ASSIGN_OR_RETURN(Query query,
                   Query::Make(database,
                               "SELECT number, outcome, verdict, is_key, rms, bare_share "
                               "FROM frame WHERE session = ? ORDER BY number"));
  query.Bind(session);
  std::vector<FrameOutline> outlines;
  for (;;) {
    ASSIGN_OR_RETURN(const bool row, query.Next());
    if (!row) return outlines;
    FrameOutline& outline = outlines.emplace_back();
    outline.sequence_number = static_cast<uint64_t>(query.Int(0));
    outline.outcome = static_cast<Outcome>(query.Int(1));
    outline.verdict = static_cast<Verdict>(query.Int(2));
    outline.key = query.Int(3) != 0;
    outline.rms = query.Real(4);
    outline.bare_share = query.Real(5);
  }
}

}  // namespace cagefit::server
