// A fixed number of workers that serve one queue per key, fair in time.
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
#include "server/session/fair_queue.h"

namespace cagefit::server {

// Milliseconds of a clock that never goes back.
double SteadyMilliseconds();
// Of one that stands still while the task of the calling thread has given way.
double BusyMilliseconds();

// Tasks of one key run one after another, in order. Keys that wait take turns by the time that they
// have used and will use (fair_queue.h); a long task that asks now and then gives way to those that
// will be done before it has used as much. Thread-safe.
class WorkerPool {
 public:
  using Task = std::function<void()>;

  // A task keeps its worker for so long before it gives way.
  static constexpr double kSliceMs = 30;

  // `name` says what queues here, for errors. `max_queued` tasks may wait. `max_paused` may have
  // given way at a time, each with a thread that sleeps.
  WorkerPool(std::string name, int workers, int64_t max_queued, int max_paused = 0,
             std::function<double()> clock = SteadyMilliseconds);
  // Runs what is queued, then ends.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  // RESOURCE_EXHAUSTED with a retry time, without running the task, when too many wait.
  absl::Status Run(const std::string& key, Task task, Priority priority = Priority::kLive);

  int64_t queued() const;  // tasks that wait

  // Called by a task of this pool wherever it may be interrupted: returns once it is its key's turn
  // again. Cheap when it is. Does nothing on other threads.
  void GiveWay();
  // Whether GiveWay would let another go first. Cheap until the slice is over.
  bool IsOvertaken();

 private:
  bool IsSliceOver() const;  // of this thread's task, if it is this pool's

  struct QueuedTask {
    Task task;
    Priority priority;
  };
  struct Lane {
    std::deque<QueuedTask> tasks;
    bool begun = false;                   // a task of it has begun and not ended
    bool paused = false;                  // and has given way
    Priority priority = Priority::kLive;  // of that task
    double since = 0;  // it has its worker, and is not charged for it, since then
    double used = 0;   // before that, by that task
    std::condition_variable resumed;
  };

  void Work();
  // All under the lock.
  void Dispatch();
  void Charge(const std::string& key, Lane* lane);
  // Charges it; unless another is to go first, its next slice begins.
  bool SliceEnds(const std::string& key, Lane* lane);
  void EndTask(const std::string& key, Lane* lane);
  absl::Duration RetryAfter() const;

  const std::string name_;
  const int workers_;
  const int64_t max_queued_;
  const int max_paused_;
  const std::function<double()> clock_;

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  int64_t queued_ = 0;  // tasks that have not begun
  int running_ = 0, paused_ = 0;
  double mean_task_ms_ = 100;  // of the last ones
  FairQueue turns_;
  std::map<std::string, Lane> lanes_;   // those with a task
  std::deque<std::string> dispatched_;  // keys whose turn it is, for the next idle thread
  std::vector<std::thread> threads_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_WORKER_POOL_H_
