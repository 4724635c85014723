// Cuts a triangle mesh along a level line.
#ifndef CAGEFIT_CORE_TEMPLATE_SURFACE_CUT_H_
#define CAGEFIT_CORE_TEMPLATE_SURFACE_CUT_H_

#include "core/mesh/triangle_mesh.h"

namespace cagefit {

// The part of `mesh` where `value`, given at its vertices and linear in between, is below `level`.
// Triangles that the line crosses are cut along it, but for a small margin at their vertices, so
// that few needles come out. Unused vertices are left out.
TriangleMesh CutBelow(const TriangleMesh& mesh, const Eigen::ArrayXd& value, double level);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_SURFACE_CUT_H_
