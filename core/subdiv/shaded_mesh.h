// The limit surface as a fine mesh with exact normals, as renderers draw it.
#ifndef CAGEFIT_CORE_SUBDIV_SHADED_MESH_H_
#define CAGEFIT_CORE_SUBDIV_SHADED_MESH_H_

#include <cstdint>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/control_mesh.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

// The vertices of LimitMesh, each once for every smooth sector of the surface around it: a vertex
// between two creases comes twice, because its normal has two values. Structure only; immutable;
// thread-safe.
class ShadedMesh {
 public:
  // The control mesh refined `levels` times, its vertices moved to their limit.
  ShadedMesh(const ControlMesh& cage, int levels);

  const Triangles& triangles() const { return triangles_; }  // as LimitMesh::triangles
  // Per vertex, the vertex of LimitMesh that it is.
  const std::vector<int32_t>& limit_vertices() const { return limit_vertices_; }
  // The triangles of LimitMesh, in which the sectors share their vertices.
  const Triangles& limit_triangles() const { return limit_triangles_; }

  // Positions and unit normals (3 x vertices each) at control vertices V (3 x n). At corners, and
  // where the surface has no tangent plane, the angle-weighted mean of the triangles' normals; (0,
  // 0, 0) where that has no direction either.
  void Evaluate(const Points3d& V, Points3d* positions, Points3d* normals) const;

 private:
  Triangles triangles_, limit_triangles_;
  std::vector<int32_t> limit_vertices_;
  std::vector<char>
      is_tip_;             // per vertex: a corner, each of whose triangles has a plane of its own
  StencilMatrix limit_;    // limit vertices x control vertices
  StencilMatrix du_, dv_;  // vertices x control vertices
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_SHADED_MESH_H_
