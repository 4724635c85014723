// Uniform refinement of Loop control meshes, and limit positions of their vertices, as
// stencils.
#ifndef CAGEFIT_CORE_SUBDIV_REFINE_H_
#define CAGEFIT_CORE_SUBDIV_REFINE_H_

#include "core/mesh/control_mesh.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

// The role of a vertex, from the number of sharp (boundary or crease) edges at it and its tags.
enum class VertexRule { kSmooth, kCrease, kCorner };

// Sharp features of one level. Boundaries are included.
struct SharpFeatures {
  std::vector<char> sharp_edge;         // per edge
  std::vector<VertexRule> vertex_rule;  // per vertex
};
SharpFeatures FindSharpFeatures(const Topology& topology, const CreaseTags& tags);

// Connectivity and matrix of one refinement step. Vertices of the finer mesh: first the n old ones,
// then one per edge in edge order. Triangle f becomes 4 f .. 4 f + 3: the three at its corners 0,
// 1, 2, then the middle one.
struct Refinement {
  Topology topology;
  CreaseTags tags;
  StencilMatrix matrix;  // finer vertices x coarser vertices
};
Refinement RefineOnce(const Topology& topology, const CreaseTags& tags);

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

#endif  // CAGEFIT_CORE_SUBDIV_REFINE_H_
