#include "server/session/byte_rate.h"

#include <algorithm>

namespace cagefit::server {

absl::Duration ByteRate::Take(int64_t bytes, int64_t per_second, absl::Time now) {
  const double full = static_cast<double>(per_second);
  std::lock_guard<std::mutex> lock(mutex_);
  // A clock that is set back pays nothing off and takes nothing away.
  const double seconds = at_.has_value() ? std::max(0.0, absl::ToDoubleSeconds(now - *at_)) : 0;
  left_ = at_.has_value() ? std::min(full, left_ + seconds * full) : full;
  at_ = now;
  left_ -= static_cast<double>(bytes);
  return left_ >= 0 ? absl::ZeroDuration() : absl::Seconds(-left_ / full);
}

}  // namespace cagefit::server
