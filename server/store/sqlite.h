// SQLite behind statuses: a connection, its statements, a transaction.
#ifndef CAGEFIT_SERVER_STORE_SQLITE_H_
#define CAGEFIT_SERVER_STORE_SQLITE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

struct sqlite3;
struct sqlite3_stmt;

namespace cagefit::server {

// UNAVAILABLE, reason STORE_UNAVAILABLE.
absl::Status StoreUnavailable(absl::string_view why);

// One user at a time. Errors of all: StoreUnavailable, with SQLite's words.
class Database {
 public:
  // Opens or makes the file, which only its owner may read. Commits are durable when they return
  // (write-ahead log, synchronous FULL).
  static absl::StatusOr<std::unique_ptr<Database>> Open(const std::string& path);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  // Any number of statements, without results.
  absl::Status Execute(const std::string& sql);
  absl::StatusOr<int64_t> Number(const std::string& sql);  // the first column of the first row

  // Another file has the path by now, or none.
  bool is_replaced() const;

  absl::Status Error(int code) const;  // of the last call on this connection

 private:
  friend class Query;
  struct CloseFn {
    void operator()(sqlite3* connection) const;
  };
  Database(std::string path, sqlite3* connection);
  absl::StatusOr<sqlite3_stmt*> Prepare(const char* sql);

  const std::string path_;
  std::unique_ptr<sqlite3, CloseFn> connection_;
  std::map<const char*, sqlite3_stmt*> statements_;  // kept for the next time
  uint64_t device_ = 0, inode_ = 0;
};

// One run of a statement. The connection keeps it prepared, by the address of its text.
class Query {
 public:
  static absl::StatusOr<Query> Make(Database* database, const char* sql);
  Query(Query&& other) noexcept;
  ~Query();

  // The next ? of the statement. Texts and blobs must live until the query does not.
  Query& Bind(int64_t value);
  Query& Bind(double value);
  Query& Bind(absl::string_view text);
  Query& BindBlob(absl::string_view blob);
  Query& BindNull();

  absl::StatusOr<bool> Next();  // whether there is another row
  absl::Status Run();           // to the end

  // Of the row; views hold until the next one.
  int64_t Int(int column) const;
  double Real(int column) const;
  absl::string_view Bytes(int column) const;
  bool IsNull(int column) const;

 private:
  Query(Database* database, sqlite3_stmt* statement) : database_(database), statement_(statement) {}

  Database* database_;
  sqlite3_stmt* statement_;
  int bound_ = 0;
};

// Rolled back unless committed.
class Transaction {
 public:
  static absl::StatusOr<Transaction> Begin(Database* database);
  Transaction(Transaction&& other) noexcept;
  ~Transaction();
  absl::Status Commit();

 private:
  explicit Transaction(Database* database) : database_(database) {}
  Database* database_;  // null once over
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_SQLITE_H_
