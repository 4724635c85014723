// Which edges and vertices of a Loop control mesh are sharp.
#ifndef CAGEFIT_CORE_SUBDIV_SHARP_FEATURES_H_
#define CAGEFIT_CORE_SUBDIV_SHARP_FEATURES_H_

#include <vector>

#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"

namespace cagefit {

// The role of a vertex. kSmooth: no sharp edge, or one (a dart); kCrease: two, whatever the number
// of faces; kCorner: three or more, or tagged.
enum class VertexRule { kSmooth, kCrease, kCorner };

// Sharp features of one level. Boundary edges are sharp.
struct SharpFeatures {
  std::vector<char> sharp_edge;         // per edge
  std::vector<VertexRule> vertex_rule;  // per vertex
};

// `tags` must name edges and vertices of `topology` (as ControlMesh::Create checks).
SharpFeatures FindSharpFeatures(const Topology& topology, const CreaseTags& tags);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_SHARP_FEATURES_H_
