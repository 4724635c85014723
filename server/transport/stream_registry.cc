#include "server/transport/stream_registry.h"

#include <vector>

#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

absl::Status ShuttingDown() {
  return WithDetail(absl::UnavailableError("the server is shutting down; go on elsewhere or later"),
                    {"DRAINING", "", "", ""});
}

}  // namespace

absl::Status StreamRegistry::Add(const std::shared_ptr<DrainableStream>& stream) {
  std::lock_guard<std::mutex> lock(mutex_);
  if (draining_) return ShuttingDown();
  const int64_t streams = static_cast<int64_t>(streams_.size());
  if (streams >= max_streams_) {
    return LimitExceeded("open streams", streams + 1, max_streams_, absl::Seconds(5));
  }
  streams_.emplace(stream.get(), stream);
  return absl::OkStatus();
}

void StreamRegistry::Remove(const DrainableStream* stream) {
  std::lock_guard<std::mutex> lock(mutex_);
  streams_.erase(stream);
}

int64_t StreamRegistry::size() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return static_cast<int64_t>(streams_.size());
}

absl::Status StreamRegistry::CheckServing() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return draining_ ? ShuttingDown() : absl::OkStatus();
}

void StreamRegistry::DrainAll() {
  std::vector<std::shared_ptr<DrainableStream>> streams;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    draining_ = true;
    for (const auto& [key, stream] : streams_) {
      if (auto alive = stream.lock()) streams.push_back(std::move(alive));
    }
  }
  for (const auto& stream : streams) stream->Drain(ShuttingDown());
}

}  // namespace cagefit::server
