// Distances between a fit and its target, as the reports give them.
//
// The fit's limit surface stands as its limit mesh (subdiv/limit.h), the target as a mesh or a
// cloud. Distances to a mesh are exact point-to-triangle distances, in target units; percentages
// are of the target's bounding-box diagonal.
#ifndef CAGEFIT_CORE_METRICS_SURFACE_METRICS_H_
#define CAGEFIT_CORE_METRICS_SURFACE_METRICS_H_

#include <cstdint>

#include "core/cloud/point_cloud.h"
#include "core/mesh/triangle_bvh.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

inline constexpr int kMetricLevels = 3;  // refinement levels of the fit
inline constexpr int kMetricSamplesPerFace = 10;

struct DistanceStats {
  double mean = 0, rms = 0, max = 0;  // target units
  int64_t samples = 0;
};

// Both directions.
struct SurfaceMetrics {
  double diagonal = 0;  // of the target's bounding box, target units
  DistanceStats target_to_fit, fit_to_target;
  // fit_to_target is by the nearest point's tangent plane: the target is a cloud.
  bool approximate = false;

  double hausdorff() const;      // the larger of the two maxima
  double symmetric_rms() const;  // root of the mean of the two squared RMS
  double Percent(double distance) const { return diagonal > 0 ? 100 * distance / diagonal : 0; }
};

// Of the points (3 x k) to the surface, which must not be empty.
DistanceStats DistancesToSurface(const Points3d& points, const TriangleBvh& surface);

// From all used vertices and kMetricSamplesPerFace area-uniform samples a face, both ways. Neither
// mesh may be without triangles.
SurfaceMetrics CompareToMesh(const TriangleMesh& fit, const TriangleMesh& target,
                             uint64_t seed = 1);

// Every target point to the fit, which must have triangles; every used vertex and sample of the fit
// to the tangent plane of its nearest target point. Where the foot on that plane is farther from
// the point than the cloud's points are from each other (3 times the median distance to the 6th
// neighbour), as beyond an open border, and where there are no normals, the distance to the point
// itself counts.
SurfaceMetrics CompareToCloud(const TriangleMesh& fit, const PointCloud& target, uint64_t seed = 1);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_METRICS_SURFACE_METRICS_H_
