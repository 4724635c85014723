#include "core/fit/normalization.h"

#include "absl/strings/str_format.h"

namespace cagefit {

absl::StatusOr<Normalization> Normalization::FromBox(const Box& box) {
  const double longest = box.size().maxCoeff();
  if (box.empty() || !(longest > 0) || !std::isfinite(longest)) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "target: its bounding box has longest side %g; it must be positive", longest));
  }
  return Normalization{0.5 * (box.min + box.max), 1 / longest};
}

Points3d Normalization::ToUnit(const Points3d& user) const {
  return (user.colwise() - center) * scale;
}

Points3d Normalization::ToUser(const Points3d& unit) const {
  return (unit / scale).colwise() + center;
}

}  // namespace cagefit
