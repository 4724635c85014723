// The limit surface of a control mesh as a fine triangle mesh.
#ifndef CAGEFIT_CLIENT_LIMIT_SURFACE_H_
#define CAGEFIT_CLIENT_LIMIT_SURFACE_H_

#include <utility>

#include "core/mesh/control_mesh.h"
#include "core/mesh/triangle_mesh.h"
#include "core/subdiv/limit.h"

namespace cagefit::client {

// Refined `levels` times, vertices at their limit positions.
inline TriangleMesh LimitSurface(const ControlMesh& cage, int levels) {
  LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), levels);
  TriangleMesh mesh;
  ApplyStencils(limit.position, cage.vertices(), &mesh.vertices);
  mesh.triangles = std::move(limit.triangles);
  return mesh;
}

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_LIMIT_SURFACE_H_
