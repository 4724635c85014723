// Limit positions of the vertices of Loop control meshes, as stencils.
#ifndef CAGEFIT_CORE_SUBDIV_LIMIT_H_
#define CAGEFIT_CORE_SUBDIV_LIMIT_H_

#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

// Limit positions of the vertices of a mesh: n x n.
StencilMatrix LimitPositionStencils(const Topology& topology, const CreaseTags& tags);

// The limit surface as a fine mesh: the control mesh refined `levels` times, its vertices moved to
// their limit.
struct LimitMesh {
  StencilMatrix position;  // vertices of the refined mesh x control vertices
  Triangles triangles;     // of the refined mesh; triangle t lies in control triangle t / 4^levels
};
LimitMesh BuildLimitMesh(const Topology& topology, const CreaseTags& tags, int levels);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_LIMIT_H_
