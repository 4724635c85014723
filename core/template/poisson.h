// A triangle mesh through a cloud, open where the cloud has no points.
#ifndef CAGEFIT_CORE_TEMPLATE_POISSON_H_
#define CAGEFIT_CORE_TEMPLATE_POISSON_H_

#include "absl/status/statusor.h"
#include "core/cloud/point_cloud.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

// Drops statistical outliers, reconstructs by screened Poisson [kazhdan2013] (Open3D) at a
// resolution that serves `control_vertices`, and trims what lies farther from the points than they
// are from each other. Short boundary loops that trimming tore are closed, ragged ones smoothed.
// INVALID_ARGUMENT for a cloud without normals, FAILED_PRECONDITION naming the step that failed.
absl::StatusOr<TriangleMesh> ReconstructPoisson(const PointCloud& cloud, int32_t control_vertices);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_POISSON_H_
