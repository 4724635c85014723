// Where an open surface ends, as points with the direction of the boundary there.
#ifndef CAGEFIT_CORE_ENERGY_BOUNDARY_CURVE_H_
#define CAGEFIT_CORE_ENERGY_BOUNDARY_CURVE_H_

#include "core/cloud/cell_grid.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

// 3 x K each; tangents and normals (of the surface) are unit vectors.
struct BoundaryCurve {
  Points3f points, tangents, normals;

  int64_t size() const { return points.cols(); }
};

// Of a mesh: edges that one triangle has, as points at most `spacing` apart, so that the line
// through the nearest of them along its tangent is the edge itself. `normals` are of the triangle.
BoundaryCurve BoundaryOfMesh(const TriangleMesh& mesh, double spacing);

// Of a cloud with normals, in `grid`, whose points are `spacing` apart: points that have no
// neighbours on one side, over an angle of kOpenAngle seen along the normal [bendels2006], where
// there are others beside them. The curve's points are the means of those around them, the tangents
// their principal directions.
// [bendels2006] G. Bendels, R. Schnabel, R. Klein, "Detecting Holes in Point Set Surfaces", 2006.
BoundaryCurve BoundaryOfCloud(const CellGrid& grid, double spacing);
inline constexpr double kOpenAngle = 2.0;  // radians

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_BOUNDARY_CURVE_H_
