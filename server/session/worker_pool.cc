#include "server/session/worker_pool.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "server/session/error_detail.h"

namespace cagefit::server {

WorkerPool::WorkerPool(std::string name, int threads, int64_t max_queued)
    : name_(std::move(name)), max_queued_(max_queued) {
  threads_.reserve(threads);
  for (int t = 0; t < threads; ++t) threads_.emplace_back([this] { Work(); });
}

WorkerPool::~WorkerPool() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

absl::Status WorkerPool::Run(const std::string& key, Task task) {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (queued_ >= max_queued_) {
      return LimitExceeded(absl::StrCat("queued ", name_), queued_ + 1, max_queued_);
    }
    ++queued_;
    Lane& lane = lanes_[key];
    if (lane.tasks.empty() && !lane.running) ready_.push_back(key);
    lane.tasks.push_back(std::move(task));
  }
  wake_.notify_one();
  return absl::OkStatus();
}

void WorkerPool::Work() {
  std::unique_lock<std::mutex> lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] { return !ready_.empty() || (ending_ && queued_ == 0); });
    if (ready_.empty()) return;
    const std::string key = std::move(ready_.front());
    ready_.pop_front();
    Lane& lane = lanes_[key];
    Task task = std::move(lane.tasks.front());
    lane.tasks.pop_front();
    lane.running = true;
    --queued_;

    lock.unlock();
    task();
    task = nullptr;  // what it holds goes before the next task of this key starts
    lock.lock();

    lane.running = false;
    if (lane.tasks.empty()) {
      lanes_.erase(key);
    } else {
      ready_.push_back(key);
    }
    // The last task of a lane may be what the others wait for when ending.
    if (ending_ || !ready_.empty()) wake_.notify_all();
  }
}

}  // namespace cagefit::server
