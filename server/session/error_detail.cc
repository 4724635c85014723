#include "server/session/error_detail.h"

#include <utility>

#include "absl/strings/cord.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace cagefit::server {
namespace {

// One payload per part: no encoding of our own, and payloads survive copies of the status.
constexpr char kReason[] = "cagefit/reason";
constexpr char kField[] = "cagefit/field";
constexpr char kValue[] = "cagefit/value";
constexpr char kLimit[] = "cagefit/limit";
constexpr char kRetryAfter[] = "cagefit/retry-after-ns";

std::string Payload(const absl::Status& status, const char* key) {
  const auto payload = status.GetPayload(key);
  return payload.has_value() ? std::string(*payload) : std::string();
}

// Zero where there is none.
absl::Duration RetryAfter(const absl::Status& status) {
  int64_t nanoseconds = 0;
  return absl::SimpleAtoi(Payload(status, kRetryAfter), &nanoseconds)
             ? absl::Nanoseconds(nanoseconds)
             : absl::ZeroDuration();
}

}  // namespace

absl::Status WithDetail(absl::Status status, const ErrorDetail& detail) {
  status.SetPayload(kReason, absl::Cord(detail.reason));
  status.SetPayload(kField, absl::Cord(detail.field));
  status.SetPayload(kValue, absl::Cord(detail.value));
  status.SetPayload(kLimit, absl::Cord(detail.limit));
  status.SetPayload(kRetryAfter,
                    absl::Cord(absl::StrCat(absl::ToInt64Nanoseconds(detail.retry_after))));
  return status;
}

std::optional<ErrorDetail> DetailOf(const absl::Status& status) {
  if (!status.GetPayload(kReason).has_value()) return std::nullopt;
  return ErrorDetail{Payload(status, kReason), Payload(status, kField), Payload(status, kValue),
                     Payload(status, kLimit), RetryAfter(status)};
}

absl::Status LimitExceeded(const std::string& field, uint64_t value, int64_t limit,
                           absl::Duration retry_after) {
  return WithDetail(
      absl::ResourceExhaustedError(absl::StrCat(field, " is ", value, "; the limit is ", limit)),
      {"LIMIT_EXCEEDED", field, absl::StrCat(value), absl::StrCat(limit), retry_after});
}

absl::Status InvalidField(const std::string& field, const std::string& value,
                          const std::string& expected) {
  return WithDetail(absl::InvalidArgumentError(absl::StrCat(field, " is ", value, "; ", expected)),
                    {"INVALID_FIELD", field, value, ""});
}

absl::Status InvalidFieldIn(const std::string& prefix, absl::string_view message) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(message, absl::MaxSplits(" is ", 1));
  const absl::string_view value = parts.second.substr(0, parts.second.find(';'));
  return WithDetail(absl::InvalidArgumentError(absl::StrCat(prefix, message)),
                    {"INVALID_FIELD", absl::StrCat(prefix, parts.first), std::string(value), ""});
}

}  // namespace cagefit::server
