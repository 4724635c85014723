// Signed distances between a limit surface and its target, for the colours of a report: positive
// where the surface lies outside of the target, by the surface's own normals.
#ifndef CAGEFIT_CLIENT_REPORT_DEVIATION_H_
#define CAGEFIT_CLIENT_REPORT_DEVIATION_H_

#include <vector>

#include "client/io/geometry_file.h"
#include "core/mesh/triangle_bvh.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit::client {

// Of the surface's vertices. To a mesh: exact distances. To a cloud: the median of those to the
// planes of the 7 nearest points, so that noise counts less and what lies behind an edge does not;
// a plane's normal is the point's or, where it has none, the surface's. The distance to the nearest
// point itself counts where that lies sideways by more than 3 times the cloud's spacing, as beyond
// a border.
std::vector<double> SurfaceDeviations(const TriangleMesh& surface, const Geometry& target);

// Of points of the target (3 x k) from the surface: exact. `bvh` is that of the surface.
std::vector<double> PointDeviations(const Points3d& points, const TriangleMesh& surface,
                                    const TriangleBvh& bvh);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_REPORT_DEVIATION_H_
