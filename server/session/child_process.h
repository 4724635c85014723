// Runs a program under limits of memory and time.
#ifndef CAGEFIT_SERVER_SESSION_CHILD_PROCESS_H_
#define CAGEFIT_SERVER_SESSION_CHILD_PROCESS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/base/cancel.h"

namespace cagefit::server {

struct ChildLimits {
  int64_t max_memory_bytes = int64_t{8} << 30;   // address space; 0: no limit
  absl::Duration max_time = absl::Seconds(120);  // by the wall clock; processor time: per core
};

struct ChildResult {
  int exit_code = -1;  // -1: ended by `signal`
  int signal = 0;
  std::string last_stderr;  // its end, at most some lines
};

// Runs `arguments[0]` (a path) without standard input, in a process group of its own that ends with
// the calling thread. CANCELLED when `cancelled` says so and RESOURCE_EXHAUSTED when `max_time` has
// passed, both after the whole group is killed; INTERNAL when no process can be started.
absl::StatusOr<ChildResult> RunChild(const std::vector<std::string>& arguments,
                                     const ChildLimits& limits, const CancelFn& cancelled);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_CHILD_PROCESS_H_
