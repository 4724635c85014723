// How many fits of one principal are in work at a time.
#ifndef CAGEFIT_SERVER_SESSION_FIT_SHARE_H_
#define CAGEFIT_SERVER_SESSION_FIT_SHARE_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>

#include "absl/status/status.h"

namespace cagefit::server {

// Tasks beyond the limit wait here, in the order in which they came, and go to the pool one by one
// as others end: the pool's own queue, where principals take turns, never holds more of one than it
// may have in work. Thread-safe; made by std::make_shared, and alive until its last task has ended.
class FitShare : public std::enable_shared_from_this<FitShare> {
 public:
  using Task = std::function<void()>;
  // Hands a task to the pool; an error means that it will not run.
  using SubmitFn = std::function<absl::Status(Task)>;
  // What becomes of a task that had to wait and that the pool then refused.
  using RefusedFn = std::function<void(const absl::Status&)>;

  // Submits `task` now, with the pool's answer, or later when `limit` tasks are in work already.
  // RESOURCE_EXHAUSTED when kMaxWaiting wait.
  absl::Status Run(int64_t limit, SubmitFn submit, Task task, RefusedFn refused);

  static constexpr int64_t kMaxWaiting = 4096;

 private:
  struct Waiting {
    SubmitFn submit;
    Task task;
    RefusedFn refused;
  };

  absl::Status Submit(const SubmitFn& submit, Task task);
  void EndOne();

  std::mutex mutex_;
  int64_t limit_ = 0;  // as the latest call had it
  int64_t in_work_ = 0;
  std::deque<Waiting> waiting_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_FIT_SHARE_H_
