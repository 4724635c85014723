// The control mesh (cage) of a Loop subdivision surface: validated connectivity, crease tags and
// control vertices.
#ifndef CAGEFIT_CORE_MESH_CONTROL_MESH_H_
#define CAGEFIT_CORE_MESH_CONTROL_MESH_H_

#include <array>
#include <memory>
#include <vector>

#include "absl/status/statusor.h"
#include "core/base/types.h"
#include "core/mesh/topology.h"

namespace cagefit {

// Infinitely sharp features beside the boundary, which is always sharp.
struct CreaseTags {
  std::vector<std::array<int32_t, 2>> edges;  // vertex pairs that are edges of the mesh
  std::vector<int32_t> corners;               // vertices that the surface interpolates
};

class ControlMesh {
 public:
  // Checks that vertices are finite, that connectivity is edge- and vertex-manifold
  // (Topology::Create), that no interior valence is below 3, that no triangle has zero area, that
  // every vertex is used, and that tags name edges and vertices of the mesh. INVALID_ARGUMENT names
  // the field and the value.
  static absl::StatusOr<ControlMesh> Create(Points3d vertices, Triangles triangles,
                                            CreaseTags tags = {});

  const Points3d& vertices() const { return vertices_; }
  const Triangles& triangles() const { return topology_->triangles(); }
  const Topology& topology() const { return *topology_; }
  const CreaseTags& tags() const { return tags_; }
  int32_t vertex_count() const { return topology_->vertex_count(); }

  // The same connectivity with other vertices (3 x n, finite).
  ControlMesh WithVertices(Points3d vertices) const;

 private:
  ControlMesh() = default;

  Points3d vertices_;
  std::shared_ptr<const Topology> topology_;
  CreaseTags tags_;
};

// Of the edges of `topology` with its vertices at V (3 x n).
double MeanEdgeLength(const Topology& topology, const Points3d& V);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_MESH_CONTROL_MESH_H_
