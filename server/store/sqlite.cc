#include "server/store/sqlite.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

constexpr int kBusyMs = 5000;  // for another process that writes

// SQLite itself would make a file that others may read.
absl::Status MakeFile(const std::string& path) {
  const int file = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0)
    return StoreUnavailable(absl::StrCat("cannot open its file: ", std::strerror(errno)));
  close(file);
  return absl::OkStatus();
}

int64_t SizeOf(const std::string& path) {
  struct stat status = {};
  return stat(path.c_str(), &status) == 0 ? static_cast<int64_t>(status.st_size) : 0;
}

}  // namespace

absl::Status StoreUnavailable(absl::string_view why) {
  return WithDetail(
      absl::UnavailableError(absl::StrCat("the session store is not available: ", why)),
      {"STORE_UNAVAILABLE", "", "", ""});
}

void Database::CloseFn::operator()(sqlite3* connection) const { sqlite3_close_v2(connection); }

Database::Database(std::string path, sqlite3* connection)
    : path_(std::move(path)), connection_(connection) {
  struct stat status = {};
  if (stat(path_.c_str(), &status) != 0) return;
  device_ = status.st_dev;
  inode_ = status.st_ino;
}

Database::~Database() {
  for (const auto& [sql, statement] : statements_) sqlite3_finalize(statement);
}

absl::StatusOr<std::unique_ptr<Database>> Database::Open(const std::string& path) {
  RETURN_IF_ERROR(MakeFile(path));
  const int64_t bytes = SizeOf(path), log_bytes = SizeOf(path + "-wal");
  sqlite3* connection = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &connection,
                                   SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
  std::unique_ptr<Database> database(new Database(path, connection));
  if (code != SQLITE_OK) return database->Error(code);
  sqlite3_extended_result_codes(connection, 1);
  sqlite3_busy_timeout(connection, kBusyMs);
  RETURN_IF_ERROR(database->Execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL"));
  // SQLite takes what is missing of the last page for zeros. With a log, the page may be there.
  ASSIGN_OR_RETURN(const int64_t page_bytes, database->Number("PRAGMA page_size"));
  if (bytes % page_bytes != 0 && log_bytes == 0) return StoreUnavailable("its file is cut off");
  return database;
}

absl::Status Database::Execute(const std::string& sql) {
  const int code = sqlite3_exec(connection_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : Error(code);
}

absl::StatusOr<int64_t> Database::Number(const std::string& sql) {
  int64_t number = 0;
  const int code = sqlite3_exec(
      connection_.get(), sql.c_str(),
      [](void* out, int, char** values, char**) {
        *static_cast<int64_t*>(out) =
            values[0] == nullptr ? 0 : std::strtoll(values[0], nullptr, 10);
        return 0;
      },
      &number, nullptr);
  if (code != SQLITE_OK) return Error(code);
  return number;
}

bool Database::is_replaced() const {
  struct stat status = {};
  return stat(path_.c_str(), &status) != 0 || status.st_dev != device_ || status.st_ino != inode_;
}

absl::Status Database::Error(int code) const {
  const char* words =
      connection_ == nullptr ? sqlite3_errstr(code) : sqlite3_errmsg(connection_.get());
  return StoreUnavailable(absl::StrCat(words, " (SQLite ", code, ")"));
}

absl::StatusOr<sqlite3_stmt*> Database::Prepare(const char* sql) {
  sqlite3_stmt*& statement = statements_[sql];
  if (statement != nullptr) return statement;
  const int code = sqlite3_prepare_v3(connection_.get(), sql, -1, SQLITE_PREPARE_PERSISTENT,
                                      &statement, nullptr);
  if (code != SQLITE_OK) return Error(code);
  return statement;
}

absl::StatusOr<Query> Query::Make(Database* database, const char* sql) {
  ASSIGN_OR_RETURN(sqlite3_stmt* const statement, database->Prepare(sql));
  return Query(database, statement);
}

Query::Query(Query&& other) noexcept
    : database_(other.database_),
      statement_(std::exchange(other.statement_, nullptr)),
      bound_(other.bound_) {}

Query::~Query() {
  if (statement_ == nullptr) return;
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
}

Query& Query::Bind(int64_t value) {
  sqlite3_bind_int64(statement_, ++bound_, value);
  return *this;
}

Query& Query::Bind(double value) {
  sqlite3_bind_double(statement_, ++bound_, value);
  return *this;
}

Query& Query::Bind(absl::string_view text) {
  sqlite3_bind_text64(statement_, ++bound_, text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8);
  return *this;
}

Query& Query::BindBlob(absl::string_view blob) {
  // A null pointer would be NULL instead of an empty blob.
  sqlite3_bind_blob64(statement_, ++bound_, blob.empty() ? "" : blob.data(), blob.size(),
                      SQLITE_STATIC);
  return *this;
}

Query& Query::BindNull() {
  sqlite3_bind_null(statement_, ++bound_);
  return *this;
}

absl::StatusOr<bool> Query::Next() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return database_->Error(code);
}

absl::Status Query::Run() {
  for (;;) {
    ASSIGN_OR_RETURN(const bool more, Next());
    if (!more) return absl::OkStatus();
  }
}

int64_t Query::Int(int column) const { return sqlite3_column_int64(statement_, column); }

double Query::Real(int column) const { return sqlite3_column_double(statement_, column); }

absl::string_view Query::Bytes(int column) const {
  const char* bytes = static_cast<const char*>(sqlite3_column_blob(statement_, column));
  return {bytes, static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
}

bool Query::IsNull(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

absl::StatusOr<Transaction> Transaction::Begin(Database* database) {
  RETURN_IF_ERROR(database->Execute("BEGIN IMMEDIATE"));
  return Transaction(database);
}

Transaction::Transaction(Transaction&& other) noexcept
    : database_(std::exchange(other.database_, nullptr)) {}

Transaction::~Transaction() {
  // After some errors SQLite has rolled back by itself, and says so.
  if (database_ != nullptr) database_->Execute("ROLLBACK").IgnoreError();
}

absl::Status Transaction::Commit() {
  RETURN_IF_ERROR(database_->Execute("COMMIT"));
  database_ = nullptr;
  return absl::OkStatus();
}

}  // namespace cagefit::server
