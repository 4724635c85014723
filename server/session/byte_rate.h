// How many bytes a second somebody may send, over all of their calls together.
#ifndef CAGEFIT_SERVER_SESSION_BYTE_RATE_H_
#define CAGEFIT_SERVER_SESSION_BYTE_RATE_H_

#include <cstdint>
#include <mutex>
#include <optional>

#include "absl/time/time.h"

namespace cagefit::server {

// A bucket that holds what one second allows and fills up again steadily. What is taken beyond it
// is a debt, which time pays off: a large message is taken whole, and what comes after it waits.
// Thread-safe; the lock is held for a few instructions.
class ByteRate {
 public:
  // Takes `bytes` of a rate of `per_second` (1 or more) and returns how long the taker has to wait
  // before more may come: zero while the bucket is not empty. The rate may change between calls.
  absl::Duration Take(int64_t bytes, int64_t per_second, absl::Time now);

 private:
  std::mutex mutex_;
  double left_ = 0;               // bytes; below 0: debt
  std::optional<absl::Time> at_;  // when left_ was right; not set: full
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_BYTE_RATE_H_
