// One large request, put together from its chunks.
#ifndef CAGEFIT_SERVER_TRANSPORT_INCOMING_BLOB_H_
#define CAGEFIT_SERVER_TRANSPORT_INCOMING_BLOB_H_

#include <cstdint>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "server/session/memory_account.h"

namespace cagefit::server {

class IncomingBlob {
 public:
  // Holds what it takes from `budget`, which must outlive it, until it is destroyed.
  IncomingBlob(int64_t max_bytes, MemoryAccount* budget)
      : max_bytes_(max_bytes), reservation_(budget) {}

  // `total_bytes` as each chunk tells it. INVALID_ARGUMENT for a chunk that does not fit to it or
  // is not 1 byte to 1 MiB long; RESOURCE_EXHAUSTED above the limit, or without room in the budget.
  absl::Status Add(uint64_t total_bytes, const std::string& data);

  // INVALID_ARGUMENT while bytes are missing.
  absl::Status CheckComplete() const;
  const std::string& bytes() const { return bytes_; }
  // Moved out; their share of the budget stays taken.
  std::string TakeBytes() { return std::move(bytes_); }

 private:
  const int64_t max_bytes_;
  MemoryReservation reservation_;
  std::string bytes_;
  uint64_t total_bytes_ = 0;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_INCOMING_BLOB_H_
