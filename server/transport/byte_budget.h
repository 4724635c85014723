// Memory that all calls together may hold in what has arrived and is not answered yet, and in what
// is not sent yet.
#ifndef CAGEFIT_SERVER_TRANSPORT_BYTE_BUDGET_H_
#define CAGEFIT_SERVER_TRANSPORT_BYTE_BUDGET_H_

#include <atomic>
#include <cstdint>
#include <utility>

#include "absl/status/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {

// Thread-safe.
class ByteBudget {
 public:
  explicit ByteBudget(int64_t limit) : limit_(limit) {}

  absl::Status Take(int64_t bytes) {
    const int64_t taken = taken_.fetch_add(bytes) + bytes;
    if (taken <= limit_) return absl::OkStatus();
    taken_.fetch_sub(bytes);
    return LimitExceeded("bytes in flight of all calls", taken, limit_);
  }
  void Give(int64_t bytes) { taken_.fetch_sub(bytes); }
  int64_t taken() const { return taken_; }

 private:
  const int64_t limit_;
  std::atomic<int64_t> taken_{0};
};

// A part of a budget that grows, and is given back when it is destroyed.
class ByteReservation {
 public:
  explicit ByteReservation(ByteBudget* budget) : budget_(budget) {}
  ByteReservation(ByteReservation&& other) noexcept
      : budget_(other.budget_), bytes_(std::exchange(other.bytes_, 0)) {}
  ByteReservation& operator=(ByteReservation&& other) noexcept {
    std::swap(budget_, other.budget_);
    std::swap(bytes_, other.bytes_);
    return *this;
  }
  ~ByteReservation() { budget_->Give(bytes_); }

  // RESOURCE_EXHAUSTED when the budget does not have as much left.
  absl::Status Grow(int64_t bytes) {
    absl::Status status = budget_->Take(bytes);
    if (status.ok()) bytes_ += bytes;
    return status;
  }

 private:
  ByteBudget* budget_;
  int64_t bytes_ = 0;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_BYTE_BUDGET_H_
