// How far the points of a target are from a fit, and which control triangles they lie over.
#ifndef CAGEFIT_CORE_FIT_TARGET_DISTANCES_H_
#define CAGEFIT_CORE_FIT_TARGET_DISTANCES_H_

#include <cstdint>
#include <vector>

#include "core/mesh/control_mesh.h"

namespace cagefit {

// Of every target point, exact to the limit mesh.
struct TargetDistances {
  std::vector<double> distance;   // in the points' units
  std::vector<int32_t> triangle;  // control triangle that holds the closest point
};

// To the limit surface of `fit`, refined until its triangles are small beside the control mesh's
// error. `points` is 3 x k.
TargetDistances DistancesToFit(const ControlMesh& fit, const Points3f& points);

// Robust extent of distances. The `left_out` farthest do not count: points that the fit took for
// outliers.
struct DistanceExtent {
  double rms = 0;
  double most = 0;  // all but a share of kFarthestShare of the points are within it
  double max = 0;   // of those that count
};
inline constexpr double kFarthestShare = 1e-3;
DistanceExtent Extent(const std::vector<double>& distances, int64_t left_out);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_TARGET_DISTANCES_H_
