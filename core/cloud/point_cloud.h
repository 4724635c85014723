// The target of a fit: points with, in most cases, unit normals.
#ifndef CAGEFIT_CORE_CLOUD_POINT_CLOUD_H_
#define CAGEFIT_CORE_CLOUD_POINT_CLOUD_H_

#include "absl/status/status.h"
#include "core/base/types.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

struct PointCloud {
  Points3f points;   // 3 x N, finite
  Points3f normals;  // 3 x N unit vectors, or 3 x 0 when there are none

  bool has_normals() const { return normals.cols() > 0; }
  int64_t size() const { return points.cols(); }
};

// Fewest points that a fit accepts.
inline constexpr int64_t kMinTargetPoints = 16;

// INVALID_ARGUMENT, naming the index, when a point is not finite, when the number of normals is
// neither 0 nor N, or when there are fewer than kMinTargetPoints points.
absl::Status ValidateTarget(const PointCloud& cloud);

// The referenced vertices of a mesh with their angle-weighted normals: a mesh used as a target
// cloud. Vertices whose normal is undefined are left out.
PointCloud CloudFromMesh(const TriangleMesh& mesh);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_POINT_CLOUD_H_
