// One large result, taken apart into chunks.
#ifndef CAGEFIT_SERVER_TRANSPORT_OUTGOING_BLOB_H_
#define CAGEFIT_SERVER_TRANSPORT_OUTGOING_BLOB_H_

#include <algorithm>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "cagefit/v1/fitting.pb.h"
#include "core/base/status.h"
#include "server/session/memory_account.h"

namespace cagefit::server {

class OutgoingBlob {
 public:
  // Holds the result's bytes from `budget`, which must outlive it, until it is destroyed: a client
  // that reads slowly holds memory.
  explicit OutgoingBlob(MemoryAccount* budget) : reservation_(budget) {}

  // Once. RESOURCE_EXHAUSTED without room in the budget.
  absl::Status Set(std::string bytes) {
    RETURN_IF_ERROR(reservation_.Grow(static_cast<int64_t>(bytes.size())));
    bytes_ = std::move(bytes);
    chunk_.set_total_bytes(bytes_.size());
    return absl::OkStatus();
  }

  // The next chunk, good until the one after it is taken; an empty result has one, too.
  const v1::DataChunk* Next() {
    constexpr size_t kChunkBytes = 1 << 20;
    const size_t count = std::min(kChunkBytes, bytes_.size() - sent_);
    chunk_.set_data(bytes_.data() + sent_, count);
    sent_ += count;
    return &chunk_;
  }
  bool is_sent() const { return sent_ == bytes_.size(); }

 private:
  MemoryReservation reservation_;
  std::string bytes_;
  size_t sent_ = 0;
  v1::DataChunk chunk_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_OUTGOING_BLOB_H_
