// More vertices where edges are long.
#ifndef CAGEFIT_CORE_TEMPLATE_EDGE_SPLIT_H_
#define CAGEFIT_CORE_TEMPLATE_EDGE_SPLIT_H_

#include "core/template/fine_surface.h"
#include "core/template/tagged_mesh.h"

namespace cagefit {

// Splits edges of a manifold mesh in two, the longest first, until it has `vertices`. New vertices
// lie on `surface`, those of boundaries and creases on its curves.
void SplitLongEdges(const FineSurface& surface, int64_t vertices, TaggedMesh* tagged);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_EDGE_SPLIT_H_
