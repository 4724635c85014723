// How far the points of a cloud are from each other.
#ifndef CAGEFIT_CORE_CLOUD_SPACING_H_
#define CAGEFIT_CORE_CLOUD_SPACING_H_

#include "core/base/types.h"
#include "core/cloud/kd_tree.h"

namespace cagefit {

// Median distance to the 6th neighbour, of about 2,000 points evenly spread over the order of
// `points` (3 x N, N > 0); to the farthest one where there are fewer. `tree` is that of the points.
double MedianSpacing(const Points3f& points, const KdTree& tree);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_SPACING_H_
