// Evens out the triangles of a control mesh without moving its surface.
#ifndef CAGEFIT_CORE_MESH_TANGENTIAL_RELAX_H_
#define CAGEFIT_CORE_MESH_TANGENTIAL_RELAX_H_

#include "core/mesh/control_mesh.h"

namespace cagefit {

// Moves every vertex within its tangent plane towards the mean of its ring, `steps` times half way,
//
//   x += 1/2 (I - n n^T) (mean of the ring - x),   n the area-weighted normal of the ring's
//                                                  triangles,
//
// all at once. Vertices of the boundary, of creases, and corners stay.
ControlMesh RelaxTangentially(const ControlMesh& mesh, int steps);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_MESH_TANGENTIAL_RELAX_H_
