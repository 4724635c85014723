// A fixed number of threads that take tasks in turn from one queue per key.
#ifndef CAGEFIT_SERVER_SESSION_WORKER_POOL_H_
#define CAGEFIT_SERVER_SESSION_WORKER_POOL_H_

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"

namespace cagefit::server {

// Tasks of one key run one after another, in order. Keys that wait are served in turn, one task
// each, so that a busy key does not starve the others. Thread-safe.
class WorkerPool {
 public:
  using Task = std::function<void()>;

  // `name` says what queues here, for errors. `max_queued` tasks may wait.
  WorkerPool(std::string name, int threads, int64_t max_queued);
  // Runs what is queued, then ends.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // RESOURCE_EXHAUSTED, without running the task, when too many wait.
  absl::Status Run(const std::string& key, Task task);

 private:
  struct Lane {
    std::deque<Task> tasks;
    bool running = false;
  };

  void Work();

  const std::string name_;
  const int64_t max_queued_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  int64_t queued_ = 0;
  std::map<std::string, Lane> lanes_;  // those with a task waiting or running
  std::deque<std::string> ready_;      // keys with a waiting task and none running, in turn
  std::vector<std::thread> threads_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_WORKER_POOL_H_
