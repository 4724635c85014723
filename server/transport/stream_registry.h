// The open streams of a server: counted, and told when it shuts down.
#ifndef CAGEFIT_SERVER_TRANSPORT_STREAM_REGISTRY_H_
#define CAGEFIT_SERVER_TRANSPORT_STREAM_REGISTRY_H_

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

#include "absl/status/status.h"

namespace cagefit::server {

// A stream that can be asked to end: it answers the frames it has, and ends with UNAVAILABLE.
class DrainableStream {
 public:
  virtual ~DrainableStream() = default;
  virtual void Drain(const absl::Status& status) = 0;
};

// Thread-safe.
class StreamRegistry {
 public:
  explicit StreamRegistry(int64_t max_streams) : max_streams_(max_streams) {}

  // RESOURCE_EXHAUSTED at the limit, UNAVAILABLE while draining.
  absl::Status Add(const std::shared_ptr<DrainableStream>& stream);
  void Remove(const DrainableStream* stream);
  int64_t size() const;  // open streams

  // OK, or UNAVAILABLE once DrainAll was called.
  absl::Status CheckServing() const;
  void DrainAll();

 private:
  const int64_t max_streams_;
  mutable std::mutex mutex_;
  bool draining_ = false;
  std::map<const DrainableStream*, std::weak_ptr<DrainableStream>> streams_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_STREAM_REGISTRY_H_
