#include "server/store/postgres.h"

#include <poll.h>

#include <array>
#include <cstring>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/base/status.h"

namespace cagefit::server {
namespace {

constexpr absl::Duration kPatience = absl::Seconds(10);  // with a statement
constexpr int kSchemaLock = 0x43616765;                  // "Cage"

std::string OneLine(const char* words) {
  std::string line = words;
  absl::StripTrailingAsciiWhitespace(&line);
  for (char& c : line) {
    if (c == '\n' || c == '\t') c = ' ';
  }
  return line;
}

uint64_t BigEndian(uint64_t value) {
  if constexpr (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__) return __builtin_bswap64(value);
  return value;
}

struct OptionsFree {
  void operator()(PQconninfoOption* options) const { PQconninfoFree(options); }
};
using Options = std::unique_ptr<PQconninfoOption, OptionsFree>;

absl::StatusOr<Options> Parse(const std::string& url) {
  char* error = nullptr;
  Options options(PQconninfoParse(url.c_str(), &error));
  if (options != nullptr) return options;
  const std::string why = error != nullptr ? OneLine(error) : "out of memory";
  PQfreemem(error);
  return absl::InvalidArgumentError(why);
}

// $1, $2 and so on for each ?, of which no literal of ours has one.
std::string Numbered(absl::string_view sql) {
  std::string numbered;
  int values = 0;
  for (const char c : sql) {
    if (c == '?') {
      absl::StrAppend(&numbered, "$", ++values);
    } else {
      numbered += c;
    }
  }
  return numbered;
}

}  // namespace

// Values and columns in PostgreSQL's binary format: bigint and double precision in network order.
class PostgresStatement final : public Statement {
 public:
  PostgresStatement(PostgresDatabase* database, std::string name)
      : database_(*database), name_(std::move(name)) {}

  void BindInt(int index, int64_t value) override {
    Number(index, BigEndian(static_cast<uint64_t>(value)));
  }
  void BindReal(int index, double value) override {
    uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof(bits));
    Number(index, BigEndian(bits));
  }
  void BindText(int index, absl::string_view text) override {
    has_nul_ |= text.find('\0') != absl::string_view::npos;
    BindBlob(index, text);
  }
  void BindBlob(int index, absl::string_view blob) override {
    // A null pointer would be NULL instead of no bytes.
    values_[index - 1] = blob.empty() ? "" : blob.data();
    lengths_[index - 1] = static_cast<int>(blob.size());
    count_ = std::max(count_, index);
  }
  void BindNull(int index) override {
    values_[index - 1] = nullptr;
    count_ = std::max(count_, index);
  }

  absl::StatusOr<bool> Next() override {
    if (result_ == nullptr) {
      if (has_nul_) return absl::InvalidArgumentError("a name or id has a zero byte");
      ASSIGN_OR_RETURN(result_, database_.Receive(PQsendQueryPrepared(
                                    database_.connection_.get(), name_.c_str(), count_,
                                    values_.data(), lengths_.data(), kBinary.data(), 1)));
    }
    return ++row_ < PQntuples(result_.get());
  }
  void Reset() override {
    result_ = nullptr;
    row_ = -1;
    count_ = 0;
    has_nul_ = false;
  }

  int64_t Int(int column) const override { return static_cast<int64_t>(Number(column)); }
  double Real(int column) const override {
    const uint64_t bits = Number(column);
    double value = 0;
    std::memcpy(&value, &bits, sizeof(value));
    return value;
  }
  absl::string_view Bytes(int column) const override {
    return {PQgetvalue(result_.get(), row_, column),
            static_cast<size_t>(PQgetlength(result_.get(), row_, column))};
  }
  bool IsNull(int column) const override { return PQgetisnull(result_.get(), row_, column) == 1; }

 private:
  static constexpr int kMostValues = 24;
  static constexpr std::array<int, kMostValues> kBinary = [] {
    std::array<int, kMostValues> formats = {};
    for (int& format : formats) format = 1;
    return formats;
  }();

  void Number(int index, uint64_t big_endian) {
    numbers_[index - 1] = big_endian;
    values_[index - 1] = reinterpret_cast<const char*>(&numbers_[index - 1]);
    lengths_[index - 1] = sizeof(big_endian);
    count_ = std::max(count_, index);
  }
  uint64_t Number(int column) const {
    uint64_t big_endian = 0;
    if (PQgetlength(result_.get(), row_, column) == sizeof(big_endian)) {
      std::memcpy(&big_endian, PQgetvalue(result_.get(), row_, column), sizeof(big_endian));
    }
    return BigEndian(big_endian);
  }

  PostgresDatabase& database_;
  const std::string name_;
  std::array<const char*, kMostValues> values_ = {};
  std::array<int, kMostValues> lengths_ = {};
  std::array<uint64_t, kMostValues> numbers_ = {};
  int count_ = 0;
  bool has_nul_ = false;
  PostgresDatabase::Result result_;  // of this run
  int row_ = -1;
};

PostgresDatabase::~PostgresDatabase() = default;

absl::StatusOr<std::unique_ptr<PostgresDatabase>> PostgresDatabase::Open(const std::string& url) {
  RETURN_IF_ERROR(CheckPostgresUrl(url));
  // Before the URL, which may say otherwise.
  const std::vector<std::pair<const char*, const char*>> settings = {
      {"application_name", "cagefitd"},
      {"connect_timeout", "5"},
      {"keepalives_idle", "10"},
      {"keepalives_interval", "5"},
      {"keepalives_count", "3"},
      {"tcp_user_timeout", "10000"},
      {"target_session_attrs", "read-write"},
      {"client_encoding", "UTF8"},
      {"dbname", url.c_str()}};
  std::vector<const char*> names, values;
  for (const auto& [name, value] : settings) {
    names.push_back(name);
    values.push_back(value);
  }
  names.push_back(nullptr);
  values.push_back(nullptr);
  std::unique_ptr<PostgresDatabase> database(
      new PostgresDatabase(PQconnectdbParams(names.data(), values.data(), 1)));
  PGconn* connection = database->connection_.get();
  if (PQstatus(connection) != CONNECTION_OK) return database->Error();
  PQsetNoticeProcessor(
      connection, [](void*, const char*) {}, nullptr);
  PQsetnonblocking(connection, 1);
  // Who is cut off must not keep rows locked. Stricter settings than "on" stay.
  RETURN_IF_ERROR(
      database->Execute("SET idle_in_transaction_session_timeout = '10s'; "
                        "SELECT set_config('synchronous_commit', 'on', false) "
                        "WHERE current_setting('synchronous_commit') IN ('off', 'local')"));
  return database;
}

const SqlDialect& PostgresDatabase::dialect() const {
  static constexpr SqlDialect kDialect = {"BEGIN ISOLATION LEVEL READ COMMITTED",
                                          "bigint PRIMARY KEY GENERATED ALWAYS AS IDENTITY",
                                          "bigint",
                                          "double precision",
                                          "text COLLATE \"C\"",
                                          "bytea",
                                          ""};
  return kDialect;
}

absl::Status PostgresDatabase::Error() const {
  return StoreUnavailable(OneLine(PQerrorMessage(connection_.get())));
}

absl::Status PostgresDatabase::Wait(bool for_writing, absl::Time deadline) {
  pollfd event = {PQsocket(connection_.get()), POLLIN, 0};
  if (for_writing) event.events |= POLLOUT;
  const absl::Duration rest = deadline - absl::Now();
  if (rest <= absl::ZeroDuration() ||
      poll(&event, 1, static_cast<int>(absl::ToInt64Milliseconds(rest)) + 1) == 0) {
    return StoreUnavailable(
        absl::StrCat("PostgreSQL has not answered for ", absl::FormatDuration(kPatience)));
  }
  if ((event.revents & ~POLLOUT) != 0 && PQconsumeInput(connection_.get()) == 0) return Error();
  return absl::OkStatus();
}

absl::StatusOr<PostgresDatabase::Result> PostgresDatabase::Receive(int sent) {
  if (sent == 0) return Error();
  const absl::Time deadline = absl::Now() + kPatience;
  for (;;) {
    const int rest = PQflush(connection_.get());
    if (rest == 0) break;
    if (rest < 0) return Error();
    RETURN_IF_ERROR(Wait(/*for_writing=*/true, deadline));
  }
  Result last;
  absl::Status status;
  for (;;) {
    while (PQisBusy(connection_.get()) == 1) {
      RETURN_IF_ERROR(Wait(/*for_writing=*/false, deadline));
    }
    Result next(PQgetResult(connection_.get()));
    if (next == nullptr) break;
    const ExecStatusType code = PQresultStatus(next.get());
    if (code != PGRES_COMMAND_OK && code != PGRES_TUPLES_OK && status.ok()) {
      const char* state = PQresultErrorField(next.get(), PG_DIAG_SQLSTATE);
      status = StoreUnavailable(absl::StrCat(OneLine(PQresultErrorMessage(next.get())),
                                             " (PostgreSQL ", state != nullptr ? state : "", ")"));
    }
    last = std::move(next);
  }
  RETURN_IF_ERROR(status);
  if (last == nullptr) return Error();
  return last;
}

absl::Status PostgresDatabase::Execute(const std::string& sql) {
  return Receive(PQsendQuery(connection_.get(), sql.c_str())).status();
}

absl::StatusOr<int64_t> PostgresDatabase::Number(const std::string& sql) {
  ASSIGN_OR_RETURN(const Result result, Receive(PQsendQuery(connection_.get(), sql.c_str())));
  int64_t number = 0;
  if (PQntuples(result.get()) == 0 || !absl::SimpleAtoi(PQgetvalue(result.get(), 0, 0), &number)) {
    return StoreUnavailable(absl::StrCat("no number came of ", sql));
  }
  return number;
}

absl::StatusOr<Statement*> PostgresDatabase::Prepare(const char* sql) {
  std::unique_ptr<Statement>& statement = statements_[sql];
  if (statement != nullptr) return statement.get();
  const std::string name = absl::StrCat("s", statements_.size());
  RETURN_IF_ERROR(
      Receive(PQsendPrepare(connection_.get(), name.c_str(), Numbered(sql).c_str(), 0, nullptr))
          .status());
  statement = std::make_unique<PostgresStatement>(this, name);
  return statement.get();
}

absl::StatusOr<int64_t> PostgresDatabase::SchemaVersion() {
  RETURN_IF_ERROR(Execute(absl::StrCat("SELECT pg_advisory_xact_lock(", kSchemaLock, ")")));
  ASSIGN_OR_RETURN(
      const int64_t is_ours,
      Number("SELECT count(*) FROM pg_class WHERE oid = to_regclass('cagefit_version')"));
  if (is_ours == 1) return Number("SELECT version FROM cagefit_version");
  ASSIGN_OR_RETURN(const int64_t tables,
                   Number("SELECT count(*) FROM pg_class WHERE oid IN (to_regclass('session'), "
                          "to_regclass('frame'), to_regclass('probe'))"));
  if (tables == 0) return 0;
  return absl::FailedPreconditionError(
      "the store's database has tables of another program; name an empty database, or a schema by "
      "options=-csearch_path=NAME in the URL");
}

absl::Status PostgresDatabase::SetSchemaVersion(int64_t version) {
  return Execute(
      absl::StrCat("CREATE TABLE IF NOT EXISTS cagefit_version (version bigint NOT NULL); "
                   "DELETE FROM cagefit_version; INSERT INTO cagefit_version VALUES (",
                   version, ")"));
}

bool PostgresDatabase::is_lost() const {
  if (PQstatus(connection_.get()) != CONNECTION_OK) return true;
  // The server says why before it hangs up; it has nothing else to say now.
  pollfd event = {PQsocket(connection_.get()), POLLIN, 0};
  if (poll(&event, 1, 0) == 0) return false;
  return PQconsumeInput(connection_.get()) == 0 || PQstatus(connection_.get()) != CONNECTION_OK;
}

absl::Status CheckPostgresUrl(const std::string& url) {
  ASSIGN_OR_RETURN(const Options options, Parse(url));
  for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
    if (std::strcmp(option->keyword, "password") != 0 || option->val == nullptr) continue;
    return absl::InvalidArgumentError(
        "it has a password, which logs and other users would see; set PGPASSWORD or PGPASSFILE");
  }
  return absl::OkStatus();
}

}  // namespace cagefit::server
