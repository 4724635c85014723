#include "server/session/worker_pool.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

// What the thread works on, if it is a worker's.
struct Place {
  const WorkerPool* pool = nullptr;
  const std::string* key = nullptr;
  double since = 0;  // its turn began
};
thread_local Place here;
thread_local double paused_ms = 0;  // of this thread, in all

constexpr double kTaskMeanShare = 0.1;  // of the latest task in the running mean

}  // namespace

double SteadyMilliseconds() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

double BusyMilliseconds() { return SteadyMilliseconds() - paused_ms; }

WorkerPool::WorkerPool(std::string name, int workers, int64_t max_queued, int max_paused,
                       std::function<double()> clock)
    : name_(std::move(name)),
      workers_(workers),
      max_queued_(max_queued),
      max_paused_(max_paused),
      clock_(std::move(clock)) {
  // With as many threads, a worker that is free finds one that is idle.
  threads_.reserve(workers + max_paused);
  for (int t = 0; t < workers + max_paused; ++t) threads_.emplace_back([this] { Work(); });
}

WorkerPool::~WorkerPool() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

absl::Status WorkerPool::Run(const std::string& key, Task task, Priority priority) {
  std::lock_guard<std::mutex> lock(mutex_);
  if (queued_ >= max_queued_) {
    return LimitExceeded(absl::StrCat("queued ", name_), queued_ + 1, max_queued_, RetryAfter());
  }
  ++queued_;
  Lane& lane = lanes_[key];
  lane.tasks.push_back({std::move(task), priority});
  if (lane.tasks.size() == 1 && !lane.begun) turns_.Add(key, priority);
  Dispatch();
  return absl::OkStatus();
}

int64_t WorkerPool::queued() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return queued_;
}

absl::Duration WorkerPool::RetryAfter() const {
  // Until half of what waits has run.
  const double ms = mean_task_ms_ * static_cast<double>(queued_) / (2.0 * workers_);
  return absl::Milliseconds(std::min(std::max(ms, 100.0), 30'000.0));
}

void WorkerPool::Dispatch() {
  while (running_ < workers_ && !turns_.empty()) {
    const std::string key = turns_.Take();
    Lane& lane = lanes_.at(key);
    lane.since = clock_();
    ++running_;
    if (lane.paused) {
      lane.paused = false;
      --paused_;
      lane.resumed.notify_one();
    } else {
      lane.begun = true;
      dispatched_.push_back(key);
      wake_.notify_one();
    }
  }
}

void WorkerPool::Charge(const std::string& key, Lane* lane) {
  const double now = clock_();
  turns_.Charge(key, now - lane->since);
  lane->used += now - lane->since;
  lane->since = now;
}

void WorkerPool::Work() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return !dispatched_.empty() || (ending_ && lanes_.empty()); });
    if (dispatched_.empty()) return;
    const std::string key = std::move(dispatched_.front());
    dispatched_.pop_front();
    Lane& lane = lanes_.at(key);
    Task task = std::move(lane.tasks.front().task);
    lane.priority = lane.tasks.front().priority;
    lane.tasks.pop_front();
    --queued_;
    here = {this, &key, lane.since};

    lock.unlock();
    task();
    task = nullptr;  // what it holds goes before the next task of this key starts
    lock.lock();

    here = {};
    EndTask(key, &lane);
    Dispatch();
    if (ending_ && lanes_.empty()) wake_.notify_all();
  }
}

void WorkerPool::EndTask(const std::string& key, Lane* lane) {
  Charge(key, lane);
  const double ms = std::exchange(lane->used, 0);
  turns_.Expect(key, ms);
  turns_.Release(key);
  --running_;
  mean_task_ms_ += kTaskMeanShare * (ms - mean_task_ms_);
  lane->begun = false;
  if (lane->tasks.empty()) {
    lanes_.erase(key);
  } else {
    turns_.Add(key, lane->tasks.front().priority);
  }
}

bool WorkerPool::IsSliceOver() const {
  return here.pool == this && clock_() - here.since >= kSliceMs;
}

bool WorkerPool::SliceEnds(const std::string& key, Lane* lane) {
  Charge(key, lane);
  if (paused_ < max_paused_ && turns_.IsOvertaken(key)) return true;
  turns_.GoOn(key);
  here.since = lane->since;
  return false;
}

bool WorkerPool::IsOvertaken() {
  if (!IsSliceOver()) return false;
  std::lock_guard<std::mutex> lock(mutex_);
  return SliceEnds(*here.key, &lanes_.at(*here.key));
}

void WorkerPool::GiveWay() {
  if (!IsSliceOver()) return;
  const std::string& key = *here.key;
  std::unique_lock<std::mutex> lock(mutex_);
  Lane& lane = lanes_.at(key);
  if (!SliceEnds(key, &lane)) return;
  turns_.Release(key);
  turns_.Add(key, lane.priority);
  lane.paused = true;
  ++paused_;
  --running_;
  Dispatch();
  const double since = SteadyMilliseconds();
  lane.resumed.wait(lock, [&lane] { return !lane.paused; });
  paused_ms += SteadyMilliseconds() - since;
  here.since = lane.since;
}

}  // namespace cagefit::server
