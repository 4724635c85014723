// Local refinement of a control mesh.
#ifndef CAGEFIT_CORE_SUBDIV_EDGE_SPLIT_H_
#define CAGEFIT_CORE_SUBDIV_EDGE_SPLIT_H_

#include <cstdint>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/mesh/control_mesh.h"

namespace cagefit {

//      c              c              c
//     / \            /|\            / \          A triangle with one, two or three split edges
//    /   \          / | \          y - x         becomes two, three or four; the diagonal of the
//   a - x - b      a  x  b ...    / \ / \        quadrangle that two leave is the shorter one.
//                                a - z - b
//
// Splits `edges` (of mesh.topology(), in any order, repeated or not) and then flips edges near them
// towards regular valences (mesh/valence_flips.h). A new vertex is placed by Loop's edge mask, and
// an old one moves towards its vertex mask by the share of its edges that are split, on a boundary
// or crease of those along the curve. So the limit surface stays inside a region whose edges are
// all split, where that is one step of Loop's refinement, and changes a little at its border. Both
// halves of a crease edge are crease edges; corners stay corners; old vertices keep their indices
// and new ones follow in the order of their edges.
//
// INVALID_ARGUMENT when the result is not a control mesh, as where a triangle loses its area.
absl::StatusOr<ControlMesh> SplitEdges(const ControlMesh& mesh, absl::Span<const int32_t> edges);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_EDGE_SPLIT_H_
