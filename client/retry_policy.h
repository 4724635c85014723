// When a client whose stream ended tries again, and when it gives up.
#ifndef CAGEFIT_CLIENT_RETRY_POLICY_H_
#define CAGEFIT_CLIENT_RETRY_POLICY_H_

#include <functional>
#include <optional>

#include "absl/status/status.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace cagefit::client {

struct RetryOptions {
  // Of trying without a reply in between. Time in which the server is at work on a frame does not
  // count.
  absl::Duration give_up_after = absl::Seconds(60);
  absl::Time deadline = absl::InfiniteFuture();  // of everything
  // Pauses double from the first to the longest, each shortened by a random share of up to a half.
  absl::Duration first_pause = absl::Milliseconds(50), longest_pause = absl::Seconds(1);
  // In a row, of a server that is exhausted and does not say until when: a frame that is too large
  // stays so.
  int most_refusals = 6;

  std::function<absl::Time()> now = absl::Now;
  std::function<double()> random;  // uniform in [0, 1); empty: seeded by chance
};

// Whether another try may go better: after UNAVAILABLE, INTERNAL and UNKNOWN, which is what broken
// connections and dead servers look like directly and through proxies, DEADLINE_EXCEEDED, which may
// be a proxy's, and RESOURCE_EXHAUSTED. All others are final, such as ABORTED of a stream that a
// newer one superseded.
bool MayPass(const absl::Status& failure);

class RetryPolicy {
 public:
  explicit RetryPolicy(RetryOptions options);

  // The stream ended, or did not open. How long to wait before the next try; nothing when there is
  // none to be.
  std::optional<absl::Duration> PauseAfter(const absl::Status& failure);
  // The stream is open: the time until its next failure does not count.
  void Opened();
  // A reply came, or nothing was asked for.
  void Progress();

  absl::Duration tried_for() const { return tried_for_; }

 private:
  absl::Duration NextPause(const absl::Status& failure);

  const RetryOptions options_;
  absl::Duration tried_for_;  // since the last progress
  std::optional<absl::Time> failing_since_;
  int failures_ = 0, refusals_ = 0;  // since the last progress
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_RETRY_POLICY_H_
