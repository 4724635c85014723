// The limit surface as a report page draws it.
#ifndef CAGEFIT_CLIENT_REPORT_DISPLAY_MESH_H_
#define CAGEFIT_CLIENT_REPORT_DISPLAY_MESH_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh/control_mesh.h"
#include "core/subdiv/stencils.h"

namespace cagefit::client {

struct DisplayMesh {
  int levels = 0;
  StencilMatrix position;     // limit vertices x control vertices
  Triangles limit_triangles;  // of limit vertices
  // The same, of drawn vertices (ShadedMesh): a limit vertex comes once for each side of the
  // creases there, so that shading stops at them as the surface does. `limit_vertices` tells which
  // it is.
  Triangles triangles;
  std::vector<int32_t> limit_vertices;
  std::vector<std::array<int32_t, 2>> creases, borders;  // edges, of limit vertices
};

// At the most refinement levels, 3 at most, at which there are `most_vertices` limit vertices or
// fewer; at none where the control mesh alone has more.
DisplayMesh BuildDisplayMesh(const ControlMesh& cage, int64_t most_vertices);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_REPORT_DISPLAY_MESH_H_
