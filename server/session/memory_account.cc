#include "server/session/memory_account.h"

#include "absl/time/time.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

// Most of what is held goes with the frame that it is for.
constexpr absl::Duration kRetryAfter = absl::Seconds(1);

}  // namespace

absl::Status MemoryAccount::Take(int64_t bytes) {
  const int64_t taken = taken_.fetch_add(bytes) + bytes;
  absl::Status status;
  if (taken > limit_) {
    status =
        LimitExceeded(name_, taken, limit_, bytes <= limit_ ? kRetryAfter : absl::ZeroDuration());
  } else if (parent_ != nullptr) {
    status = parent_->Take(bytes);
  }
  if (!status.ok()) taken_.fetch_sub(bytes);
  if (status.ok() && taken_fn_) taken_fn_(bytes);
  return status;
}

void MemoryAccount::Give(int64_t bytes) {
  taken_.fetch_sub(bytes);
  if (parent_ != nullptr) parent_->Give(bytes);
}

absl::Status MemoryReservation::Grow(int64_t bytes) {
  absl::Status status = account_->Take(bytes);
  if (status.ok()) bytes_ += bytes;
  return status;
}

void MemoryReservation::ShrinkTo(int64_t bytes) {
  if (bytes >= bytes_) return;
  account_->Give(bytes_ - bytes);
  bytes_ = bytes;
}

}  // namespace cagefit::server
