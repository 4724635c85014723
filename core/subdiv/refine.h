// Uniform refinement of Loop control meshes as a sparse matrix.
#ifndef CAGEFIT_CORE_SUBDIV_REFINE_H_
#define CAGEFIT_CORE_SUBDIV_REFINE_H_

#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"
#include "core/subdiv/limit.h"  // IWYU pragma: export
#include "core/subdiv/sharp_features.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

//        c0
//       /  \          Triangle f = (c0 c1 c2), with a new vertex e_c in the middle of its c-th
//     e0 -- e2        half-edge, becomes
//     / \  / \          4 f = (c0 e0 e2), 4 f + 1 = (c1 e1 e0), 4 f + 2 = (c2 e2 e1),
//   c1 - e1 - c2        4 f + 3 = (e0 e1 e2).
//
// Vertices of the finer mesh: first the n old ones, then one per edge in edge order.
Triangles SplitTriangles(const Topology& topology);

// One refinement step. Both halves of a crease edge are crease edges; corners stay corners.
struct Refinement {
  Topology topology;
  CreaseTags tags;
  StencilMatrix matrix;  // finer vertices x coarser vertices
};
Refinement RefineOnce(const Topology& topology, const CreaseTags& tags);

// The matrix of one refinement step alone.
StencilMatrix RefinementStencils(const Topology& topology, const SharpFeatures& sharp);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_REFINE_H_
