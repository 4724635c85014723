#include "client/retry_policy.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <utility>

#include "client/status_from_grpc.h"

namespace cagefit::client {
namespace {

// As the server asked.
std::optional<absl::Duration> RetryAfter(const absl::Status& failure) {
  const std::optional<v1::ErrorDetail> detail = DetailOf(failure);
  if (!detail.has_value() || !detail->has_retry_after()) return std::nullopt;
  const google::protobuf::Duration& after = detail->retry_after();
  return std::max(absl::ZeroDuration(),
                  absl::Seconds(after.seconds()) + absl::Nanoseconds(after.nanos()));
}

std::function<double()> RandomByChance() {
  const auto random = std::make_shared<std::mt19937>(std::random_device()());
  return [random] { return std::uniform_real_distribution<double>()(*random); };
}

RetryOptions Complete(RetryOptions options) {
  if (!options.random) options.random = RandomByChance();
  return options;
}

}  // namespace

bool MayPass(const absl::Status& failure) {
  switch (failure.code()) {
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kResourceExhausted:
      return true;
    default:
      return false;
  }
}

RetryPolicy::RetryPolicy(RetryOptions options) : options_(Complete(std::move(options))) {}

std::optional<absl::Duration> RetryPolicy::PauseAfter(const absl::Status& failure) {
  const absl::Time now = options_.now();
  if (failing_since_.has_value()) tried_for_ += now - *failing_since_;
  failing_since_ = now;
  if (!MayPass(failure)) return std::nullopt;
  const bool is_bare_refusal =
      absl::IsResourceExhausted(failure) && !RetryAfter(failure).has_value();
  refusals_ = is_bare_refusal ? refusals_ + 1 : 0;
  if (refusals_ >= options_.most_refusals) return std::nullopt;
  const absl::Duration pause = NextPause(failure);
  if (tried_for_ + pause > options_.give_up_after) return std::nullopt;
  if (now + pause >= options_.deadline) return std::nullopt;
  return pause;
}

absl::Duration RetryPolicy::NextPause(const absl::Status& failure) {
  constexpr int kMostDoublings = 30;
  const absl::Duration whole =
      std::min(options_.longest_pause,
               options_.first_pause * std::ldexp(1.0, std::min(failures_++, kMostDoublings)));
  const absl::Duration pause = whole * (1 - 0.5 * options_.random());
  // Beyond what the server asked for, so that all who were sent away do not come back at once.
  return RetryAfter(failure).value_or(absl::ZeroDuration()) + pause;
}

void RetryPolicy::Opened() {
  if (failing_since_.has_value()) tried_for_ += options_.now() - *failing_since_;
  failing_since_.reset();
}

void RetryPolicy::Progress() {
  tried_for_ = absl::ZeroDuration();
  failures_ = refusals_ = 0;
  failing_since_.reset();
}

}  // namespace cagefit::client
