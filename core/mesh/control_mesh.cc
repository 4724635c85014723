#include "core/mesh/control_mesh.h"

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/status.h"

namespace cagefit {

namespace {

absl::Status CheckGeometry(const Points3d& vertices, const Topology& topology) {
  for (int64_t v = 0; v < vertices.cols(); ++v) {
    if (!vertices.col(v).allFinite()) {
      return absl::InvalidArgumentError(absl::StrFormat("vertex %d: (%g, %g, %g) is not finite", v,
                                                        vertices(0, v), vertices(1, v),
                                                        vertices(2, v)));
    }
    if (!topology.IsBoundaryVertex(static_cast<int32_t>(v)) &&
        topology.Valence(static_cast<int32_t>(v)) < 3) {
      return absl::InvalidArgumentError(
          absl::StrFormat("vertex %d: interior valence %d; at least 3 is needed", v,
                          topology.Valence(static_cast<int32_t>(v))));
    }
  }
  for (int64_t f = 0; f < topology.triangle_count(); ++f) {
    const auto t = topology.triangles().col(f);
    const Eigen::Vector3d a = vertices.col(t[1]) - vertices.col(t[0]);
    const Eigen::Vector3d b = vertices.col(t[2]) - vertices.col(t[0]);
    if (!(a.cross(b).norm() > 0)) {
      return absl::InvalidArgumentError(
          absl::StrFormat("triangle %d (%d, %d, %d): its area is 0", f, t[0], t[1], t[2]));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckTags(const CreaseTags& tags, const Topology& topology) {
  for (const auto& edge : tags.edges) {
    if (topology.FindEdge(edge[0], edge[1]) == Topology::kNone) {
      return absl::InvalidArgumentError(
          absl::StrFormat("crease edge (%d, %d): the mesh has no such edge", edge[0], edge[1]));
    }
  }
  for (const int32_t v : tags.corners) {
    if (v < 0 || v >= topology.vertex_count()) {
      return absl::InvalidArgumentError(
          absl::StrFormat("corner %d is outside [0, %d)", v, topology.vertex_count()));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<ControlMesh> ControlMesh::Create(Points3d vertices, Triangles triangles,
                                                CreaseTags tags) {
  ASSIGN_OR_RETURN(Topology topology,
                   Topology::Create(static_cast<int32_t>(vertices.cols()), std::move(triangles)));
  RETURN_IF_ERROR(CheckGeometry(vertices, topology));
  RETURN_IF_ERROR(CheckTags(tags, topology));
  ControlMesh mesh;
  mesh.vertices_ = std::move(vertices);
  mesh.topology_ = std::make_shared<const Topology>(std::move(topology));
  mesh.tags_ = std::move(tags);
  return mesh;
}

ControlMesh ControlMesh::WithVertices(Points3d vertices) const {
  ControlMesh mesh = *this;
  mesh.vertices_ = std::move(vertices);
  return mesh;
}

double MeanEdgeLength(const Topology& topology, const Points3d& V) {
  double sum = 0;
  for (int32_t e = 0; e < topology.edge_count(); ++e) {
    const auto& [a, b] = topology.edge(e);
    sum += (V.col(a) - V.col(b)).norm();
  }
  return sum / topology.edge_count();
}

}  // namespace cagefit
