#include "server/session/readiness.h"

#include <utility>

namespace cagefit::server {

void Readiness::Set(const std::string& reason) {
  std::lock_guard<std::mutex> lock(mutex_);
  reasons_.insert(reason);
  Update();
}

void Readiness::Clear(const std::string& reason) {
  std::lock_guard<std::mutex> lock(mutex_);
  reasons_.erase(reason);
  Update();
}

std::vector<std::string> Readiness::Reasons() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return {reasons_.begin(), reasons_.end()};
}

void Readiness::Listen(Listener listener) {
  std::lock_guard<std::mutex> lock(mutex_);
  listeners_.push_back(std::move(listener));
}

void Readiness::Update() {
  const bool ready = reasons_.empty();
  if (ready_.exchange(ready) == ready) return;
  for (const Listener& listener : listeners_) listener(ready);
}

}  // namespace cagefit::server
