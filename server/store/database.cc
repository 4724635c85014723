#include "server/store/database.h"

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {

absl::Status StoreUnavailable(absl::string_view why) {
  return WithDetail(
      absl::UnavailableError(absl::StrCat("the session store is not available: ", why)),
      {"STORE_UNAVAILABLE", "", "", ""});
}

absl::StatusOr<Query> Query::Make(Database* database, const char* sql) {
  ASSIGN_OR_RETURN(Statement* const statement, database->Prepare(sql));
  return Query(statement);
}

Query::~Query() {
  if (statement_ != nullptr) statement_->Reset();
}

Query& Query::Bind(int64_t value) {
  statement_->BindInt(++bound_, value);
  return *this;
}

Query& Query::Bind(double value) {
  statement_->BindReal(++bound_, value);
  return *this;
}

Query& Query::Bind(absl::string_view text) {
  statement_->BindText(++bound_, text);
  return *this;
}

Query& Query::BindBlob(absl::string_view blob) {
  statement_->BindBlob(++bound_, blob);
  return *this;
}

Query& Query::BindNull() {
  statement_->BindNull(++bound_);
  return *this;
}

absl::Status Query::Run() {
  for (;;) {
    ASSIGN_OR_RETURN(const bool more, Next());
    if (!more) return absl::OkStatus();
  }
}

absl::StatusOr<Transaction> Transaction::Begin(Database* database) {
  RETURN_IF_ERROR(database->Execute(database->dialect().begin));
  return Transaction(database);
}

Transaction::~Transaction() {
  // After some errors a database has rolled back by itself, and says so.
  if (database_ != nullptr) database_->Execute("ROLLBACK").IgnoreError();
}

absl::Status Transaction::Commit() {
  RETURN_IF_ERROR(database_->Execute("COMMIT"));
  database_ = nullptr;
  return absl::OkStatus();
}

}  // namespace cagefit::server
