// A mesh as the target of a fit: its surface, not its vertices alone.
#ifndef CAGEFIT_CORE_CLOUD_SURFACE_CLOUD_H_
#define CAGEFIT_CORE_CLOUD_SURFACE_CLOUD_H_

#include "core/cloud/point_cloud.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

// The referenced vertices with their normals (`normals`, 3 x N, or angle-weighted ones where that
// is 3 x 0; vertices whose normal is undefined are left out), and points inside the triangles with
// the triangles' normals: a surface through the vertices alone would lie outside where the mesh is
// convex. Triangles whose longest edge exceeds twice the spacing are filled at that spacing, which
// is the median edge length, or less where the mesh has few triangles; the others give their
// middle, unless there are more than 150,000. At most kMaxFillPerVertex points are added per
// vertex, or kFillOfSmallMesh in all if that is more.
inline constexpr int64_t kMaxFillPerVertex = 4;
inline constexpr int64_t kFillOfSmallMesh = 20'000;
PointCloud SurfaceCloud(const TriangleMesh& mesh, const Points3f& normals);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_SURFACE_CLOUD_H_
