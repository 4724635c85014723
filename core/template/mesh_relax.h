// Better triangles for subdivision: even valences and no needles, on the same surface.
#ifndef CAGEFIT_CORE_TEMPLATE_MESH_RELAX_H_
#define CAGEFIT_CORE_TEMPLATE_MESH_RELAX_H_

#include "core/template/fine_surface.h"
#include "core/template/tagged_mesh.h"

namespace cagefit {

// Flips edges of a manifold mesh where that brings the four valences closer to 6 (4 on a boundary)
// without turning a triangle or a needle up, and moves interior vertices along the surface towards
// the middle of their ring, back onto `surface`. `rounds` of both, in turn. Vertices of boundaries
// and creases move along these, and only where that makes thin triangles better: the collapse has
// put them where the curves bend. Corners stay, and crease edges are not flipped.
void RelaxMesh(const FineSurface& surface, int rounds, TaggedMesh* tagged);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_MESH_RELAX_H_
