// The session's similarity transform: user units to the unit box in which energies are evaluated.
#ifndef CAGEFIT_CORE_FIT_NORMALIZATION_H_
#define CAGEFIT_CORE_FIT_NORMALIZATION_H_

#include "absl/status/statusor.h"
#include "core/base/types.h"

namespace cagefit {

// x_unit = (x_user - center) * scale puts the first target's bounding box into [-0.5, 0.5]^3,
// longest side 1.
struct Normalization {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // user units
  double scale = 1;                                  // 1 / user unit

  // INVALID_ARGUMENT when the box is empty, flat to a point, or not finite.
  static absl::StatusOr<Normalization> FromBox(const Box& box);

  Points3d ToUnit(const Points3d& user) const;
  Points3d ToUser(const Points3d& unit) const;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_NORMALIZATION_H_
