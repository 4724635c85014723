// SQLite behind Database.
#ifndef CAGEFIT_SERVER_STORE_SQLITE_H_
#define CAGEFIT_SERVER_STORE_SQLITE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "server/store/database.h"

struct sqlite3;

namespace cagefit::server {

class SqliteDatabase final : public Database {
 public:
  // Opens or makes the file, which only its owner may read. Commits are durable when they return
  // (write-ahead log, synchronous FULL).
  static absl::StatusOr<std::unique_ptr<SqliteDatabase>> Open(const std::string& path);
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
  absl::Status Error(int code) const;  // of the last call on this connection

  const std::string path_;
  std::unique_ptr<sqlite3, CloseFn> connection_;
  std::map<const char*, std::unique_ptr<Statement>> statements_;
  uint64_t device_ = 0, inode_ = 0;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_SQLITE_H_
