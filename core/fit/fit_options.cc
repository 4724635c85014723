#include "core/fit/fit_options.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "core/base/status.h"

namespace cagefit {

namespace {

absl::Status CheckRange(const char* field, double value, double least, double most) {
  if (value >= least && value <= most) return absl::OkStatus();  // false for NaN
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %g; it must be from %g to %g", field, value, least, most));
}

}  // namespace

absl::Status FitOptions::Validate() const {
  RETURN_IF_ERROR(CheckRange("radius", distance.radius, 0, 1e12));
  RETURN_IF_ERROR(CheckRange("radius_factor", distance.radius_factor, 0.5, 20));
  RETURN_IF_ERROR(CheckRange("far_radius", distance.far_radius, 0, 1e12));
  RETURN_IF_ERROR(CheckRange("arap_weight", arap.weight.value_or(0), 0, 1e6));
  RETURN_IF_ERROR(CheckRange("max_iterations", solver.max_iterations, 1, 10'000));
  RETURN_IF_ERROR(CheckRange("relative_decrease", solver.relative_decrease, 1e-12, 0.5));
  RETURN_IF_ERROR(CheckRange("first_stiffness", solver.first_stiffness, 1, 1e6));
  return absl::OkStatus();
}

}  // namespace cagefit
