// Takes the last needles out of a template, which collapse and relaxation leave where they are
// wedged between sharp features or high valences.
#ifndef CAGEFIT_CORE_TEMPLATE_NEEDLE_REMOVAL_H_
#define CAGEFIT_CORE_TEMPLATE_NEEDLE_REMOVAL_H_

#include "core/template/fine_surface.h"
#include "core/template/tagged_mesh.h"

namespace cagefit {

// Changes the surroundings of every triangle of a manifold mesh whose quality (TriangleQuality) is
// below `quality`, worst first, as long as the worst triangle there gets better: by collapsing one
// of its edges, by flipping one, or, where a vertex lies close to a boundary or crease opposite, by
// taking it up into that curve. Curves and corners stay as in CollapseEdges, but that two corners
// may merge along a crease much shorter than anything the fit resolves. Vertices that move come to
// lie on `surface` or its curves. The mesh may lose vertices.
void RemoveNeedles(const FineSurface& surface, double quality, TaggedMesh* tagged);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_NEEDLE_REMOVAL_H_
