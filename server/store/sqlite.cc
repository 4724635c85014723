#include "server/store/sqlite.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

constexpr int kBusyMs = 5000;                   // for another process that writes
constexpr int64_t kApplicationId = 0x43616765;  // "Cage"

absl::Status ErrorOf(sqlite3* connection, int code) {
  const char* words = connection == nullptr ? sqlite3_errstr(code) : sqlite3_errmsg(connection);
  return StoreUnavailable(absl::StrCat(words, " (SQLite ", code, ")"));
}

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

class SqliteStatement final : public Statement {
 public:
  explicit SqliteStatement(sqlite3_stmt* statement) : statement_(statement) {}
  ~SqliteStatement() override { sqlite3_finalize(statement_); }

  void BindInt(int index, int64_t value) override { sqlite3_bind_int64(statement_, index, value); }
  void BindReal(int index, double value) override { sqlite3_bind_double(statement_, index, value); }
  void BindText(int index, absl::string_view text) override {
    sqlite3_bind_text64(statement_, index, text.data(), text.size(), SQLITE_STATIC, SQLITE_UTF8);
  }
  void BindBlob(int index, absl::string_view blob) override {
    // A null pointer would be NULL instead of an empty blob.
    sqlite3_bind_blob64(statement_, index, blob.empty() ? "" : blob.data(), blob.size(),
                        SQLITE_STATIC);
  }
  void BindNull(int index) override { sqlite3_bind_null(statement_, index); }

  absl::StatusOr<bool> Next() override {
    const int code = sqlite3_step(statement_);
    if (code == SQLITE_ROW) return true;
    if (code == SQLITE_DONE) return false;
    return ErrorOf(sqlite3_db_handle(statement_), code);
  }
  void Reset() override {
    sqlite3_reset(statement_);
    sqlite3_clear_bindings(statement_);
  }

  int64_t Int(int column) const override { return sqlite3_column_int64(statement_, column); }
  double Real(int column) const override { return sqlite3_column_double(statement_, column); }
  absl::string_view Bytes(int column) const override {
    const char* bytes = static_cast<const char*>(sqlite3_column_blob(statement_, column));
    return {bytes, static_cast<size_t>(sqlite3_column_bytes(statement_, column))};
  }
  bool IsNull(int column) const override {
    return sqlite3_column_type(statement_, column) == SQLITE_NULL;
  }

 private:
  sqlite3_stmt* const statement_;
};

}  // namespace

SqliteJournalMode JournalModeOn(int64_t file_system) {
  constexpr int64_t kZfs = 0x2fc12fc1, kBcachefs = 0xca451a4e;
  switch (file_system) {
    case BTRFS_SUPER_MAGIC:
    case EXT4_SUPER_MAGIC:
    case F2FS_SUPER_MAGIC:
    case OVERLAYFS_SUPER_MAGIC:
    case RAMFS_MAGIC:
    case TMPFS_MAGIC:
    case XFS_SUPER_MAGIC:
    case kBcachefs:
    case kZfs:
      return SqliteJournalMode::kWriteAheadLog;
    default:
      return SqliteJournalMode::kRollback;
  }
}

void SqliteDatabase::CloseFn::operator()(sqlite3* connection) const {
  sqlite3_close_v2(connection);
}

SqliteDatabase::SqliteDatabase(std::string path, sqlite3* connection)
    : path_(std::move(path)), connection_(connection) {
  struct stat status = {};
  if (stat(path_.c_str(), &status) != 0) return;
  device_ = status.st_dev;
  inode_ = status.st_ino;
}

SqliteDatabase::~SqliteDatabase() = default;  // statements first

absl::StatusOr<std::unique_ptr<SqliteDatabase>> SqliteDatabase::Open(
    const std::string& path, std::optional<SqliteJournalMode> mode) {
  RETURN_IF_ERROR(MakeFile(path));
  if (!mode.has_value()) {
    struct statfs status = {};
    if (statfs(path.c_str(), &status) != 0) return StoreUnavailable(std::strerror(errno));
    mode = JournalModeOn(status.f_type);
  }
  const int64_t bytes = SizeOf(path), log_bytes = SizeOf(path + "-wal") + SizeOf(path + "-journal");
  sqlite3* connection = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &connection,
                                   SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
  std::unique_ptr<SqliteDatabase> database(new SqliteDatabase(path, connection));
  if (code != SQLITE_OK) return database->Error(code);
  sqlite3_extended_result_codes(connection, 1);
  sqlite3_busy_timeout(connection, kBusyMs);
  RETURN_IF_ERROR(database->SetJournalMode(*mode));
  // SQLite takes what is missing of the last page for zeros. With a log or a rollback journal, the
  // page may be there.
  ASSIGN_OR_RETURN(const int64_t page_bytes, database->Number("PRAGMA page_size"));
  if (bytes % page_bytes != 0 && log_bytes == 0) return StoreUnavailable("its file is cut off");
  return database;
}

const SqlDialect& SqliteDatabase::dialect() const {
  static constexpr SqlDialect kDialect = {
      "BEGIN IMMEDIATE", "INTEGER PRIMARY KEY", "INTEGER", "REAL", "TEXT", "BLOB", "STRICT"};
  return kDialect;
}

absl::Status SqliteDatabase::Execute(const std::string& sql) {
  const int code = sqlite3_exec(connection_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  return code == SQLITE_OK ? absl::OkStatus() : Error(code);
}

absl::Status SqliteDatabase::SetJournalMode(SqliteJournalMode mode) {
  // TRUNCATE, unlike DELETE, syncs the end of a commit, too.
  const bool log = mode == SqliteJournalMode::kWriteAheadLog;
  RETURN_IF_ERROR(Execute(
      absl::StrCat("PRAGMA synchronous = FULL; PRAGMA journal_mode = ", log ? "WAL" : "TRUNCATE")));
  ASSIGN_OR_RETURN(const int64_t in_force,
                   Number(absl::StrCat("SELECT journal_mode = '", log ? "wal" : "truncate",
                                       "' FROM pragma_journal_mode")));
  if (in_force != 0) return absl::OkStatus();
  return StoreUnavailable("another process has its file open in the other journal mode");
}

absl::StatusOr<int64_t> SqliteDatabase::Number(const std::string& sql) {
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

absl::StatusOr<int64_t> SqliteDatabase::SchemaVersion() {
  ASSIGN_OR_RETURN(const int64_t application, Number("PRAGMA application_id"));
  ASSIGN_OR_RETURN(const int64_t tables, Number("SELECT count(*) FROM sqlite_schema"));
  if (tables > 0 && application != kApplicationId) {
    return absl::FailedPreconditionError("the store's file is a database of another program");
  }
  return Number("PRAGMA user_version");
}

absl::Status SqliteDatabase::SetSchemaVersion(int64_t version) {
  return Execute(absl::StrCat("PRAGMA user_version = ", version,
                              "; PRAGMA application_id = ", kApplicationId));
}

bool SqliteDatabase::is_lost() const {
  struct stat status = {};
  return stat(path_.c_str(), &status) != 0 || status.st_dev != device_ || status.st_ino != inode_;
}

absl::Status SqliteDatabase::Error(int code) const { return ErrorOf(connection_.get(), code); }

absl::StatusOr<Statement*> SqliteDatabase::Prepare(const char* sql) {
  std::unique_ptr<Statement>& statement = statements_[sql];
  if (statement != nullptr) return statement.get();
  sqlite3_stmt* prepared = nullptr;
  const int code =
      sqlite3_prepare_v3(connection_.get(), sql, -1, SQLITE_PREPARE_PERSISTENT, &prepared, nullptr);
  if (code != SQLITE_OK) return Error(code);
  statement = std::make_unique<SqliteStatement>(prepared);
  return statement.get();
}

}  // namespace cagefit::server
