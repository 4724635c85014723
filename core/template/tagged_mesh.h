// A triangle mesh on its way to a control mesh: its sharp features go with it.
#ifndef CAGEFIT_CORE_TEMPLATE_TAGGED_MESH_H_
#define CAGEFIT_CORE_TEMPLATE_TAGGED_MESH_H_

#include "core/mesh/control_mesh.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

// `tags` name edges and vertices of `mesh`.
struct TaggedMesh {
  TriangleMesh mesh;
  CreaseTags tags;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_TAGGED_MESH_H_
