// SQLite behind Database.
#ifndef CAGEFIT_SERVER_STORE_SQLITE_H_
#define CAGEFIT_SERVER_STORE_SQLITE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "server/store/database.h"

struct sqlite3;

namespace cagefit::server {

// What makes a commit whole. With a log it is written once and synced once, but all processes that
// have the file open share memory, so they have to be on one machine. With a rollback journal it is
// written twice and synced more often, and machines keep out of each other's way by locks alone.
enum class SqliteJournalMode { kWriteAheadLog, kRollback };

// kWriteAheadLog on the file systems of one machine: those that are known, by the type that
// statfs(2) gives.
SqliteJournalMode JournalModeOn(int64_t file_system);

class SqliteDatabase final : public Database {
 public:
  // Opens or makes the file, which only its owner may read. Commits are durable when they return
  // (synchronous FULL). A file that was opened in the other mode before changes to this one, and is
  // UNAVAILABLE while another process has it open. Without `mode`, the file system's.
  static absl::StatusOr<std::unique_ptr<SqliteDatabase>> Open(
      const std::string& path, std::optional<SqliteJournalMode> mode = std::nullopt);
  ~SqliteDatabase() override;
  SqliteDatabase(const SqliteDatabase&) = delete;
  SqliteDatabase& operator=(const SqliteDatabase&) = delete;

  const SqlDialect& dialect() const override;
  absl::Status Execute(const std::string& sql) override;
  absl::StatusOr<int64_t> Number(const std::string& sql) override;
  absl::StatusOr<Statement*> Prepare(const char* sql) override;
  absl::StatusOr<int64_t> SchemaVersion() override;
  absl::Status SetSchemaVersion(int64_t version) override;
  // Another file has the path by now, or none.
  bool is_lost() const override;

 private:
  struct CloseFn {
    void operator()(sqlite3* connection) const;
  };
  SqliteDatabase(std::string path, sqlite3* connection);
  absl::Status SetJournalMode(SqliteJournalMode mode);
  absl::Status Error(int code) const;  // of the last call on this connection

  const std::string path_;
  std::unique_ptr<sqlite3, CloseFn> connection_;
  std::map<const char*, std::unique_ptr<Statement>> statements_;
  uint64_t device_ = 0, inode_ = 0;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_SQLITE_H_
