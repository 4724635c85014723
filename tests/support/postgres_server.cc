#include "tests/support/postgres_server.h"

#include <libpq-fe.h>
#include <pwd.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"

namespace cagefit::testing {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void GiveUp(const std::string& why) {
  std::fprintf(stderr, "PostgreSQL for tests: %s\n", why.c_str());
  std::abort();
}

// Debian keeps the programs of each version in a folder of its own.
std::string Program(const std::string& name) {
  std::error_code error;
  for (const auto& version : fs::directory_iterator("/usr/lib/postgresql", error)) {
    const fs::path program = version.path() / "bin" / name;
    if (fs::exists(program)) return program.string();
  }
  GiveUp(name + " is not installed; deploy/setup.sh brings it");
}

// It does not run as root.
void BecomePostgres() {
  if (geteuid() != 0) return;
  const passwd* user = getpwnam("postgres");
  if (user == nullptr || setgid(user->pw_gid) != 0 || setuid(user->pw_uid) != 0) _exit(126);
}

// In a process group of its own, which ends with this process.
pid_t Run(const std::vector<std::string>& command, const std::string& log) {
  std::vector<char*> arguments;
  for (const std::string& argument : command) {
    arguments.push_back(const_cast<char*>(argument.c_str()));
  }
  arguments.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child != 0) return child;
  setpgid(0, 0);
  BecomePostgres();
  prctl(PR_SET_PDEATHSIG, SIGINT);
  if (getppid() != parent) _exit(126);
  if (std::freopen(log.c_str(), "a", stderr) == nullptr) _exit(126);
  dup2(STDERR_FILENO, STDOUT_FILENO);
  execv(arguments[0], arguments.data());
  _exit(127);
}

bool Succeeds(pid_t child) {
  int status = -1;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

PostgresServer::PostgresServer() {
  std::string folder = (fs::temp_directory_path() / "cagefit_postgres.XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) GiveUp("no temporary folder");
  folder_ = folder;
  if (geteuid() == 0) {
    const passwd* user = getpwnam("postgres");
    if (user == nullptr || chown(folder_.c_str(), user->pw_uid, user->pw_gid) != 0) {
      GiveUp("no user postgres");
    }
  }
  if (!Succeeds(Run({Program("initdb"), "-D", folder_ + "/data", "-A", "trust", "-U", "cagefit",
                     "-E", "UTF8", "--locale=C", "--no-sync"},
                    folder_ + "/log"))) {
    GiveUp("initdb failed");
  }
  Start();
}

PostgresServer::~PostgresServer() {
  Stop();
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

void PostgresServer::Start() {
  process_ = Run({Program("postgres"), "-D", folder_ + "/data", "-k", folder_, "-c",
                  "listen_addresses=", "-c", "shared_buffers=16MB"},
                 folder_ + "/log");
  const absl::Time deadline = absl::Now() + absl::Seconds(60);
  while (PQping(Url("postgres").c_str()) != PQPING_OK) {
    if (absl::Now() > deadline) GiveUp("it does not start");
    absl::SleepFor(absl::Milliseconds(20));
  }
}

void PostgresServer::Stop() {
  if (process_ < 0) return;
  Signal(SIGCONT);
  kill(process_, SIGQUIT);
  waitpid(process_, nullptr, 0);
  process_ = -1;
}

void PostgresServer::Freeze() const { Signal(SIGSTOP); }
void PostgresServer::Thaw() const { Signal(SIGCONT); }

// Backends leave the process group for groups of their own.
void PostgresServer::Signal(int signal) const {
  std::error_code ignored;
  for (const auto& entry :
       fs::directory_iterator(absl::StrCat("/proc/", process_, "/task"), ignored)) {
    FILE* children = std::fopen((entry.path() / "children").c_str(), "r");
    int child = 0;
    while (children != nullptr && std::fscanf(children, "%d", &child) == 1) kill(child, signal);
    if (children != nullptr) std::fclose(children);
  }
  kill(process_, signal);
}

std::string PostgresServer::Url(const std::string& database) const {
  return absl::StrCat("postgresql:///", database, "?host=", folder_, "&user=cagefit");
}

std::string PostgresServer::NewDatabase() {
  const std::string name = absl::StrCat("test", ++databases_);
  PGconn* connection = PQconnectdb(Url("postgres").c_str());
  PGresult* made = PQexec(connection, ("CREATE DATABASE " + name).c_str());
  if (PQresultStatus(made) != PGRES_COMMAND_OK) GiveUp(PQerrorMessage(connection));
  PQclear(made);
  PQfinish(connection);
  return Url(name);
}

}  // namespace cagefit::testing
