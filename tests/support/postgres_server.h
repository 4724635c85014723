// A PostgreSQL of the test's own, on a socket in a folder of its own.
#ifndef CAGEFIT_TESTS_SUPPORT_POSTGRES_SERVER_H_
#define CAGEFIT_TESTS_SUPPORT_POSTGRES_SERVER_H_

#include <sys/types.h>

#include <string>

namespace cagefit::testing {

// Ends, and its folder goes, with the test. Aborts the test program when PostgreSQL cannot be
// started: the tests' packages bring it.
class PostgresServer {
 public:
  PostgresServer();
  ~PostgresServer();
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  // Of a new, empty database.
  std::string NewDatabase();

  void Stop();  // at once, as if it crashed
  void Start();
  // All of its processes stand still, with connections open, until Thaw.
  void Freeze() const;
  void Thaw() const;

 private:
  std::string Url(const std::string& database) const;
  void Signal(int signal) const;

  std::string folder_;
  pid_t process_ = -1;
  int databases_ = 0;
};

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_POSTGRES_SERVER_H_
