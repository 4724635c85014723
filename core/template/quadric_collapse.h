// Edge collapse by quadric error [garland1997] that keeps a manifold mesh manifold.
#ifndef CAGEFIT_CORE_TEMPLATE_QUADRIC_COLLAPSE_H_
#define CAGEFIT_CORE_TEMPLATE_QUADRIC_COLLAPSE_H_

#include <cstdint>

#include "core/template/tagged_mesh.h"

namespace cagefit {

// Collapses edges of a manifold mesh, cheapest first, until `vertices` are left or no edge may
// collapse. An edge may collapse when its ends share exactly the neighbours of its triangles (link
// condition), no triangle turns over or becomes a needle, and no valence falls below 3 (2 on a
// boundary) or rises above 9. Besides distance to the planes of the original triangles, the error
// counts distance to the curves (boundaries and creases), and a little of the distance to the
// original vertices, so that flat regions keep well-shaped triangles.
//
// Curves stay curves: their vertices merge along them alone, inner vertices merge into them,
// corners and the ends of creases do not move, and no edge between two curves collapses. The tags
// of the result name its own edges and vertices.
TaggedMesh CollapseEdges(const TaggedMesh& mesh, int64_t vertices);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_QUADRIC_COLLAPSE_H_
