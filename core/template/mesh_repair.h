// Turns a triangle soup into a manifold mesh by leaving out and splitting, never by adding.
#ifndef CAGEFIT_CORE_TEMPLATE_MESH_REPAIR_H_
#define CAGEFIT_CORE_TEMPLATE_MESH_REPAIR_H_

#include <vector>

#include "core/mesh/triangle_mesh.h"

namespace cagefit {

struct RepairReport {
  int64_t dropped_triangles = 0;  // degenerate, doubled, or a third one at an edge
  int64_t split_vertices = 0;     // vertices where several fans of triangles met
};

// Merges vertices at the same position, drops triangles of no area and those that would make an
// edge non-manifold or badly oriented (the first ones win), gives every fan its own vertex, and
// leaves unused vertices out.
TriangleMesh MakeManifold(const TriangleMesh& mesh, RepairReport* report);

// Keeps the connected components with at least `share` of the largest one's area. Writes how many
// were kept and dropped.
TriangleMesh KeepLargeComponents(const TriangleMesh& mesh, double share, int* kept, int* dropped);

// The triangles of `mesh` for which keep[f] is set, unused vertices left out.
TriangleMesh SelectTriangles(const TriangleMesh& mesh, const std::vector<char>& keep);

// Flips the longest side of triangles so flat that their three corners lie on a line but for a
// thousandth of the bounding box's diagonal, where that gives better triangles: the surface stays
// where it is, and along a sharp edge it no longer has a second one beside. `mesh` must be
// manifold.
void FlipCaps(TriangleMesh* mesh);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_MESH_REPAIR_H_
