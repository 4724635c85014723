// Distances between a fit and its target, as the reports give them.
//
// The fit's limit surface stands as its limit mesh (subdiv/refine.h), the target as a mesh or a
// cloud. Distances are exact point-to-triangle distances, in target units; percentages are of the
// target's bounding-box diagonal.
#ifndef CAGEFIT_CORE_METRICS_SURFACE_METRICS_H_
#define CAGEFIT_CORE_METRICS_SURFACE_METRICS_H_

#include <cstdint>

#include "core/cloud/point_cloud.h"
#include "core/mesh/triangle_bvh.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

inline constexpr int kMetricLevels = 3;  // refinement levels of the fit
inline constexpr int kMetricSamplesPerFace =
    10;  // area-uniform samples of a mesh, per face on average

struct DistanceStats {
  double mean = 0, rms = 0, max = 0;  // target units
  int64_t samples = 0;
};

// Both directions. hausdorff is the larger of the two maxima, symmetric_rms the root of the mean of
// the two squared RMS.
struct SurfaceMetrics {
  double diagonal = 0;  // of the target's bounding box, target units
  DistanceStats target_to_fit, fit_to_target;
  bool approximate =
      false;  // fit_to_target by the nearest point's tangent plane (target is a cloud)
  double hausdorff() const;
  double symmetric_rms() const;
  double Percent(double distance) const { return diagonal > 0 ? 100 * distance / diagonal : 0; }
};

// From all vertices and kMetricSamplesPerFace area-uniform samples a face (seeded), both ways.
SurfaceMetrics CompareToMesh(const TriangleMesh& fit, const TriangleMesh& target,
                             uint64_t seed = 1);

// Every target point to the fit; every fit vertex and sample to the tangent plane of its nearest
// target point, bounded by the distance to that point. Without normals, to the nearest point
// itself.
SurfaceMetrics CompareToCloud(const TriangleMesh& fit, const PointCloud& target, uint64_t seed = 1);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_METRICS_SURFACE_METRICS_H_
