#include "server/session/child_process.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "core/base/sanitizer.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

constexpr int kPollMs = 20;
constexpr size_t kStderrBytes = 2000;

// AddressSanitizer reserves terabytes of addresses for what it notes.
constexpr bool kCanLimitAddresses = CAGEFIT_ADDRESS_SANITIZER == 0;

// Between fork and exec, in a process that had other threads: system calls only.
[[noreturn]] void ExecChild(char* const* arguments, int stderr_fd, const ChildLimits& limits,
                            pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(126);  // the parent went before the line above
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);  // the server blocks SIGTERM for itself
  signal(SIGPIPE, SIG_DFL);

  const rlim_t memory = kCanLimitAddresses && limits.max_memory_bytes > 0
                            ? static_cast<rlim_t>(limits.max_memory_bytes)
                            : RLIM_INFINITY;
  const rlimit memory_limit = {memory, memory};
  // Every core may be busy all the time: this only stops what outlives its parent's clock.
  const rlim_t seconds = static_cast<rlim_t>(absl::ToInt64Seconds(limits.max_time) + 1) *
                         static_cast<rlim_t>(sysconf(_SC_NPROCESSORS_ONLN));
  const rlimit cpu_limit = {seconds, seconds};
  const rlimit no_core = {0, 0};
  if (setrlimit(RLIMIT_AS, &memory_limit) != 0 || setrlimit(RLIMIT_CPU, &cpu_limit) != 0 ||
      setrlimit(RLIMIT_CORE, &no_core) != 0) {
    _exit(126);
  }
  const int null = open("/dev/null", O_RDWR);
  dup2(null, STDIN_FILENO);
  dup2(null, STDOUT_FILENO);
  dup2(stderr_fd, STDERR_FILENO);
  syscall(SYS_close_range, STDERR_FILENO + 1, ~0U, 0);  // sockets of the server are not its own
  execv(arguments[0], arguments);
  _exit(127);
}

// Reads what is there; keeps the end.
void Drain(int fd, std::string* text) {
  char buffer[4096];
  for (ssize_t got; (got = read(fd, buffer, sizeof(buffer))) > 0;) {
    text->append(buffer, static_cast<size_t>(got));
    if (text->size() > 2 * kStderrBytes) text->erase(0, text->size() - kStderrBytes);
  }
}

// Waits for the child's end, polling: cancellation is a question, not an event.
absl::StatusOr<int> Wait(pid_t child, int stderr_fd, const ChildLimits& limits,
                         const CancelFn& cancelled, std::string* last_stderr) {
  const absl::Time deadline = absl::Now() + limits.max_time;
  for (;;) {
    Drain(stderr_fd, last_stderr);
    int wait_status = 0;
    if (waitpid(child, &wait_status, WNOHANG) == child) {
      kill(-child, SIGKILL);  // what it may have left behind
      Drain(stderr_fd, last_stderr);
      return wait_status;
    }
    absl::Status stop;
    // Time first: who is asked whether to go on may take long to answer, and then the child's end
    // is looked for before its time is up.
    if (absl::Now() <= deadline) {
      if (IsCancelled(cancelled))
        stop = absl::CancelledError("cancelled while a template was made");
    } else {
      stop = LimitExceeded("seconds of the template program",
                           absl::ToInt64Seconds(limits.max_time) + 1,
                           absl::ToInt64Seconds(limits.max_time));
    }
    if (!stop.ok()) {
      kill(-child, SIGKILL);
      kill(child, SIGKILL);  // in case it has no group yet
      waitpid(child, &wait_status, 0);
      return stop;
    }
    pollfd ready = {stderr_fd, POLLIN, 0};
    // After the other end is closed, poll returns at once; the child then ends within moments.
    if (poll(&ready, 1, kPollMs) > 0 && (ready.revents & POLLHUP) != 0)
      absl::SleepFor(absl::Milliseconds(1));
  }
}

}  // namespace

absl::StatusOr<ChildResult> RunChild(const std::vector<std::string>& arguments,
                                     const ChildLimits& limits, const CancelFn& cancelled) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  int pipe_fds[2];
  if (pipe2(pipe_fds, O_CLOEXEC) != 0) {
    return absl::InternalError(absl::StrCat("pipe: ", strerror(errno)));
  }
  fcntl(pipe_fds[0], F_SETFL, O_NONBLOCK);  // a child that writes much waits until it is read
  const pid_t parent = getpid();
  const pid_t child = fork();
  if (child == 0) ExecChild(argv.data(), pipe_fds[1], limits, parent);
  const int fork_error = errno;
  close(pipe_fds[1]);
  if (child < 0) {
    close(pipe_fds[0]);
    return absl::InternalError(absl::StrCat("fork: ", strerror(fork_error)));
  }
  ChildResult result;
  const auto wait_status = Wait(child, pipe_fds[0], limits, cancelled, &result.last_stderr);
  close(pipe_fds[0]);
  RETURN_IF_ERROR(wait_status.status());
  if (WIFEXITED(*wait_status)) {
    result.exit_code = WEXITSTATUS(*wait_status);
  } else {
    result.signal = WTERMSIG(*wait_status);
  }
  if (result.last_stderr.size() > kStderrBytes) {
    result.last_stderr.erase(0, result.last_stderr.size() - kStderrBytes);
  }
  return result;
}

}  // namespace cagefit::server
