#include "server/session/fit_share.h"

#include <utility>

#include "server/session/error_detail.h"

namespace cagefit::server {

absl::Status FitShare::Run(int64_t limit, SubmitFn submit, Task task, RefusedFn refused) {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    limit_ = limit;
    // Nobody overtakes those that wait: frames of a session keep their order.
    if (in_work_ >= limit_ || !waiting_.empty()) {
      const int64_t waiting = static_cast<int64_t>(waiting_.size());
      if (waiting >= kMaxWaiting) return LimitExceeded("waiting fits", waiting + 1, kMaxWaiting);
      waiting_.push_back({std::move(submit), std::move(task), std::move(refused)});
      return absl::OkStatus();
    }
    ++in_work_;
  }
  absl::Status submitted = Submit(submit, std::move(task));
  if (!submitted.ok()) EndOne();
  return submitted;
}

absl::Status FitShare::Submit(const SubmitFn& submit, Task task) {
  return submit([self = shared_from_this(), task = std::move(task)]() mutable {
    task();
    task = nullptr;  // what it holds goes before the next task starts
    self->EndOne();
  });
}

void FitShare::EndOne() {
  std::unique_lock<std::mutex> lock(mutex_);
  --in_work_;
  while (!waiting_.empty() && in_work_ < limit_) {
    Waiting next = std::move(waiting_.front());
    waiting_.pop_front();
    ++in_work_;
    lock.unlock();
    const absl::Status submitted = Submit(next.submit, std::move(next.task));
    if (!submitted.ok()) next.refused(submitted);
    next = Waiting();
    lock.lock();
    if (!submitted.ok()) --in_work_;
  }
}

}  // namespace cagefit::server
