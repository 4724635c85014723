// A SQL database behind statuses: a connection, its statements, a transaction. Statements are in
// what SQLite and PostgreSQL have in common, with ? for their values.
#ifndef CAGEFIT_SERVER_STORE_DATABASE_H_
#define CAGEFIT_SERVER_STORE_DATABASE_H_

#include <cstdint>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace cagefit::server {

// UNAVAILABLE, reason STORE_UNAVAILABLE.
absl::Status StoreUnavailable(absl::string_view why);

// How a database spells what the tables are made of.
struct SqlDialect {
  const char* begin;  // a transaction that writes
  const char* key;    // type of a primary key that counts up by itself
  const char* integer;
  const char* real;
  const char* text;  // compared byte by byte
  const char* blob;
  const char* table_end;  // behind the columns
};

// A prepared statement, run by one Query at a time.
class Statement {
 public:
  virtual ~Statement() = default;

  // Values from 1 on. Texts and blobs must live until Reset.
  virtual void BindInt(int index, int64_t value) = 0;
  virtual void BindReal(int index, double value) = 0;
  virtual void BindText(int index, absl::string_view text) = 0;
  virtual void BindBlob(int index, absl::string_view blob) = 0;
  virtual void BindNull(int index) = 0;

  virtual absl::StatusOr<bool> Next() = 0;  // whether there is another row
  virtual void Reset() = 0;                 // for the next run

  // Of the row, columns from 0 on; views hold until the next one.
  virtual int64_t Int(int column) const = 0;
  virtual double Real(int column) const = 0;
  virtual absl::string_view Bytes(int column) const = 0;
  virtual bool IsNull(int column) const = 0;
};

// One user at a time. Errors of all: StoreUnavailable, with the database's words.
class Database {
 public:
  virtual ~Database() = default;
  virtual const SqlDialect& dialect() const = 0;

  // Any number of statements, without results.
  virtual absl::Status Execute(const std::string& sql) = 0;
  virtual absl::StatusOr<int64_t> Number(const std::string& sql) = 0;  // first column of one row
  // Kept for the next time, by the address of its text.
  virtual absl::StatusOr<Statement*> Prepare(const char* sql) = 0;

  // In a transaction that begins with it, and that no other server's overlaps: how many steps of
  // the schema are taken, 0 in an empty store. FAILED_PRECONDITION where another program's tables
  // are.
  virtual absl::StatusOr<int64_t> SchemaVersion() = 0;
  virtual absl::Status SetSchemaVersion(int64_t version) = 0;

  // The connection leads nowhere any more.
  virtual bool is_lost() const = 0;
};

// One run of a statement.
class Query {
 public:
  static absl::StatusOr<Query> Make(Database* database, const char* sql);
  Query(Query&& other) noexcept
      : statement_(std::exchange(other.statement_, nullptr)), bound_(other.bound_) {}
  ~Query();

  // The next ? of the statement. Texts and blobs must live until the query does not.
  Query& Bind(int64_t value);
  Query& Bind(double value);
  Query& Bind(absl::string_view text);
  Query& BindBlob(absl::string_view blob);
  Query& BindNull();

  absl::StatusOr<bool> Next() { return statement_->Next(); }
  absl::Status Run();  // to the end

  int64_t Int(int column) const { return statement_->Int(column); }
  double Real(int column) const { return statement_->Real(column); }
  absl::string_view Bytes(int column) const { return statement_->Bytes(column); }
  bool IsNull(int column) const { return statement_->IsNull(column); }

 private:
  explicit Query(Statement* statement) : statement_(statement) {}

  Statement* statement_;
  int bound_ = 0;
};

// Rolled back unless committed.
class Transaction {
 public:
  static absl::StatusOr<Transaction> Begin(Database* database);
  Transaction(Transaction&& other) noexcept : database_(std::exchange(other.database_, nullptr)) {}
  ~Transaction();
  absl::Status Commit();

 private:
  explicit Transaction(Database* database) : database_(database) {}
  Database* database_;  // null once over
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_DATABASE_H_
