// Quick per-frame judgement from a sample of the target, cheap enough for every reply.
#ifndef CAGEFIT_CORE_METRICS_VERDICT_H_
#define CAGEFIT_CORE_METRICS_VERDICT_H_

#include <cstdint>
#include <optional>

#include "core/cloud/point_cloud.h"
#include "core/mesh/triangle_bvh.h"
#include "core/metrics/surface_metrics.h"

namespace cagefit {

enum class Verdict { kOk, kSuspect, kLost };

struct SampledDistances {
  double mean = 0, rms = 0, max = 0;  // target to fit, user units
  double uncovered_share = 0;         // of sampled points farther than the cover distance
  int samples = 0;
};

// Distances of `count` points, evenly spread over the cloud's order (all of them if there are
// fewer), to the fit.
SampledDistances SampleDistances(const PointCloud& target, const TriangleBvh& fit, int count,
                                 double cover_distance);

struct VerdictInput {
  SampledDistances distances;
  double median_rms = 0;     // of the session's earlier OK frames; 0 when there are none
  double diagonal = 0;       // of the session's first target
  double flipped_share = 0;  // of limit mesh triangles turned by more than 90 degrees against the
                             // template's, relative to their neighbours
  // Share of the surface that has no target near it, and its median over the session's earlier OK
  // frames, not set when there are none: where a part is suddenly missing, the surface lies on what
  // is left and all distances are small.
  double bare_share = 0;
  std::optional<double> median_bare_share;
};
Verdict Judge(const VerdictInput& input);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_METRICS_VERDICT_H_
