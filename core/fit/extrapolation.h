// Where a moving mesh may be next.
#ifndef CAGEFIT_CORE_FIT_EXTRAPOLATION_H_
#define CAGEFIT_CORE_FIT_EXTRAPOLATION_H_

#include "core/base/types.h"

namespace cagefit {

// From two states of a mesh (3 x n each, n >= 1) one step apart, one step on: with T the rigid
// motion that takes `before` nearest to `now` [umeyama1991] and R its rotation,
//
//   x_next = T x_now + momentum R ( x_now - T x_before )
//
// so that what turns goes on along its circle, and what bends goes on bending, in the frame that
// turns with it, `momentum` times as fast. Extrapolating coordinates instead inflates a body that
// turns.
Points3d ExtrapolateMotion(const Points3d& before, const Points3d& now, double momentum);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_EXTRAPOLATION_H_
