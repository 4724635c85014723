// How far material points slide along the fitted surface: against ground truth, or without it by
// going forth and back.
//
// Each ground-truth vertex is bound at frame 0 to the closest point (triangle, u, v) of the fit's
// limit mesh. Drift in frame t is the displacement of that bound point since frame 0 minus the true
// displacement.
//
// Round trip: a sequence that is fitted forth and then back to where it began has moved by nothing,
// so what the limit mesh's vertices have moved is drift. It is no upper bound: what slides one way
// on the way there and back again is not seen.
#ifndef CAGEFIT_CORE_METRICS_DRIFT_H_
#define CAGEFIT_CORE_METRICS_DRIFT_H_

#include <vector>

#include "core/mesh/triangle_bvh.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

struct DriftStats {
  double mean = 0, rms = 0, max = 0;  // units of the input
  double tangential_mean = 0;         // of the part in the bound point's tangent plane
};

class DriftMeter {
 public:
  // `fit` and `truth` (3 x k) of frame 0.
  DriftMeter(const TriangleMesh& fit, const Points3d& truth);

  // `fit_vertices` of the same limit mesh in frame t, `truth` of frame t.
  DriftStats Measure(const Points3d& fit_vertices, const Points3d& truth) const;

 private:
  Triangles triangles_;
  std::vector<ClosestPoint> bound_;  // per ground-truth vertex
  Points3d truth_;                   // frame 0
};

// Of the vertices of a limit mesh, from a fit of a frame to `returned` (as many), a later fit of
// the same frame. The tangential part is that in the tangent planes of `fit`.
DriftStats RoundTripDrift(const TriangleMesh& fit, const Points3d& returned);

// Over several frames that measured equally many points: means of means, the root of the mean of
// the squared RMS, the largest maximum.
DriftStats Combine(const std::vector<DriftStats>& frames);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_METRICS_DRIFT_H_
