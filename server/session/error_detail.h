// Machine-readable part of an error, carried as status payloads: what a client may act on without
// reading the message.
#ifndef CAGEFIT_SERVER_SESSION_ERROR_DETAIL_H_
#define CAGEFIT_SERVER_SESSION_ERROR_DETAIL_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "absl/time/time.h"

namespace cagefit::server {

struct ErrorDetail {
  std::string reason;                                 // UPPER_SNAKE_CASE, stable
  std::string field;                                  // of the request
  std::string value;                                  // offending
  std::string limit;                                  // that it met, if any
  absl::Duration retry_after = absl::ZeroDuration();  // 0: waiting does not help
};

// `status` (not OK) with `detail` attached; replaces an earlier detail.
absl::Status WithDetail(absl::Status status, const ErrorDetail& detail);

// Nothing when none was attached.
std::optional<ErrorDetail> DetailOf(const absl::Status& status);

// RESOURCE_EXHAUSTED, reason LIMIT_EXCEEDED: "`field` is `value`; the limit is `limit`". With
// `retry_after` where the same may pass later.
absl::Status LimitExceeded(const std::string& field, uint64_t value, int64_t limit,
                           absl::Duration retry_after = absl::ZeroDuration());

// INVALID_ARGUMENT, reason INVALID_FIELD: "`field` is `value`; `expected`".
absl::Status InvalidField(const std::string& field, const std::string& value,
                          const std::string& expected);

// As InvalidField, of a check in core: `message` is "FIELD is VALUE" or "FIELD is VALUE; EXPECTED",
// and `prefix` what the field stands in.
absl::Status InvalidFieldIn(const std::string& prefix, absl::string_view message);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_ERROR_DETAIL_H_
