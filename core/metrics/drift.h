// How far material points slide along the fitted surface, against ground truth.
//
// Each ground-truth vertex is bound at frame 0 to the closest point (triangle, u, v) of the fit's
// limit mesh. Drift in frame t is the displacement of that bound point since frame 0 minus the true
// displacement.
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

}  // namespace cagefit

#endif  // CAGEFIT_CORE_METRICS_DRIFT_H_
