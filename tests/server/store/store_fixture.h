// Journals with something in them.
#ifndef CAGEFIT_TESTS_SERVER_STORE_STORE_FIXTURE_H_
#define CAGEFIT_TESTS_SERVER_STORE_STORE_FIXTURE_H_

#include <memory>
#include <string>
#include <utility>

#include "core/base/private_folder.h"
#include "server/store/postgres.h"
#include "server/store/sql_journal.h"
#include "server/store/sqlite.h"
#include "server/transport/record_convert.h"
#include "tests/server/session/session_fixture.h"

namespace cagefit::server::testing {

inline SessionRecord RecordOf(const std::string& id, SessionConfig config = CageConfig()) {
  SessionRecord record;
  record.id = id;
  record.owner = "somebody";
  record.created = absl::FromUnixSeconds(5) + absl::Nanoseconds(7);
  if (config.control_mesh.has_value()) {
    record.head.control_vertices = config.control_mesh->vertex_count();
    record.head.triangles = config.control_mesh->topology().triangle_count();
  }
  record.config = std::move(config);
  return record;
}

inline std::shared_ptr<StoredFrame> RejectedAnswer(uint64_t number) {
  auto frame = std::make_shared<StoredFrame>();
  frame->sequence_number = number;
  frame->error = InvalidField("a.field", "bad", "expected better");
  return frame;
}

inline std::unique_ptr<SqlJournal> OpenFile(
    const std::string& path, const RecordCodec* codec,
    SqliteJournalMode mode = SqliteJournalMode::kWriteAheadLog) {
  return SqlJournal::Open([=] { return SqliteDatabase::Open(path, mode); }, 1, codec).value();
}

inline std::unique_ptr<SqlJournal> OpenPostgres(const std::string& url, const RecordCodec* codec) {
  return SqlJournal::Open([url] { return PostgresDatabase::Open(url); }, 3, codec).value();
}

// A file in a folder of its own.
class StoreFile {
 public:
  std::string folder() const { return folder_.path(); }
  std::string path() const { return folder_.path() + "/sessions.db"; }
  std::unique_ptr<SqlJournal> Open(
      SqliteJournalMode mode = SqliteJournalMode::kWriteAheadLog) const {
    return OpenFile(path(), &codec_, mode);
  }

 private:
  PrivateFolder folder_ = PrivateFolder::Create().value();
  ProtoRecordCodec codec_;
};

}  // namespace cagefit::server::testing

#endif  // CAGEFIT_TESTS_SERVER_STORE_STORE_FIXTURE_H_
