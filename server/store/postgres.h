// PostgreSQL behind Database.
#ifndef CAGEFIT_SERVER_STORE_POSTGRES_H_
#define CAGEFIT_SERVER_STORE_POSTGRES_H_

#include <libpq-fe.h>

#include <map>
#include <memory>
#include <string>

#include "server/store/database.h"

namespace cagefit::server {

// Does not wait for ever: whoever does not answer in time is lost.
class PostgresDatabase final : public Database {
 public:
  // `url` as libpq has it (postgresql://...), with PGPASSWORD, PGPASSFILE and so on beside it.
  // Commits are durable when they return, whatever the server's default. INVALID_ARGUMENT as
  // CheckPostgresUrl.
  static absl::StatusOr<std::unique_ptr<PostgresDatabase>> Open(const std::string& url);
  ~PostgresDatabase() override;
  PostgresDatabase(const PostgresDatabase&) = delete;
  PostgresDatabase& operator=(const PostgresDatabase&) = delete;

  const SqlDialect& dialect() const override;
  absl::Status Execute(const std::string& sql) override;
  absl::StatusOr<int64_t> Number(const std::string& sql) override;
  absl::StatusOr<Statement*> Prepare(const char* sql) override;
  absl::StatusOr<int64_t> SchemaVersion() override;
  absl::Status SetSchemaVersion(int64_t version) override;
  bool is_lost() const override;

 private:
  friend class PostgresStatement;
  struct FinishFn {
    void operator()(PGconn* connection) const { PQfinish(connection); }
  };
  struct ClearFn {
    void operator()(PGresult* result) const { PQclear(result); }
  };
  using Result = std::unique_ptr<PGresult, ClearFn>;

  explicit PostgresDatabase(PGconn* connection) : connection_(connection) {}

  // The last result of what was sent, `sent` as PQsend... returns it.
  absl::StatusOr<Result> Receive(int sent);
  absl::Status Wait(bool for_writing, absl::Time deadline);
  absl::Status Error() const;  // of the connection

  std::unique_ptr<PGconn, FinishFn> connection_;
  std::map<const char*, std::unique_ptr<Statement>> statements_;
};

// OK when libpq understands the URL and nothing in it is secret; INVALID_ARGUMENT.
absl::Status CheckPostgresUrl(const std::string& url);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_STORE_POSTGRES_H_
