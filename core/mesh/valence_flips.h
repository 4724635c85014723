// Edge flips that bring valences near the regular ones: 6 inside, 4 on a boundary.
#ifndef CAGEFIT_CORE_MESH_VALENCE_FLIPS_H_
#define CAGEFIT_CORE_MESH_VALENCE_FLIPS_H_

#include <vector>

#include "core/mesh/control_mesh.h"

namespace cagefit {

//      c                  c
//     / \                /|\         Flips {a, b} to {c, d} where that lowers the sum of squared
//    a---b      ->      a | b        differences from the regular valence, the shape hardly changes
//     \ /                \|/         (the four triangles face the same way within 30 degrees) and
//      d                  d          the triangles stay well shaped.
//
// Boundary and crease edges stay. Only edges of a triangle that `movable` (per triangle) names are
// flipped; both triangles keep their indices. `triangles` must be manifold over `vertices` (3 x n).
void FlipTowardsRegularValence(const Points3d& vertices, const CreaseTags& tags,
                               const std::vector<char>& movable, Triangles* triangles);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_MESH_VALENCE_FLIPS_H_
