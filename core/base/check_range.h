// Errors of options that are out of range.
#ifndef CAGEFIT_CORE_BASE_CHECK_RANGE_H_
#define CAGEFIT_CORE_BASE_CHECK_RANGE_H_

#include "absl/status/status.h"
#include "absl/strings/str_format.h"

namespace cagefit {

// INVALID_ARGUMENT, naming field, value and range, unless least <= value <= most; so for NaN, too.
inline absl::Status CheckRange(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %g; it must be from %g to %g", field, value, least, most));
}

}  // namespace cagefit

#endif  // CAGEFIT_CORE_BASE_CHECK_RANGE_H_
