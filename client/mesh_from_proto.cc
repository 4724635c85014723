#include "client/mesh_from_proto.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace cagefit::client {

v1::ControlMesh ToProto(const ControlMesh& mesh) {
  v1::ControlMesh proto;
  const Points3d& vertices = mesh.vertices();
  proto.mutable_vertices()->Add(vertices.data(), vertices.data() + vertices.size());
  const Triangles& triangles = mesh.triangles();
  proto.mutable_triangles()->Add(triangles.data(), triangles.data() + triangles.size());
  for (const auto& edge : mesh.tags().edges) {
    proto.mutable_crease_edges()->Add(edge.begin(), edge.end());
  }
  proto.mutable_corners()->Add(mesh.tags().corners.begin(), mesh.tags().corners.end());
  return proto;
}

absl::StatusOr<ControlMesh> FromProto(const v1::ControlMesh& proto) {
  if (proto.vertices_size() % 3 != 0 || proto.triangles_size() % 3 != 0 ||
      proto.crease_edges_size() % 2 != 0) {
    return absl::DataLossError("control mesh: its lists are cut off");
  }
  Points3d vertices(3, proto.vertices_size() / 3);
  std::copy(proto.vertices().begin(), proto.vertices().end(), vertices.data());
  Triangles triangles(3, proto.triangles_size() / 3);
  std::copy(proto.triangles().begin(), proto.triangles().end(), triangles.data());
  CreaseTags tags;
  for (int k = 0; k < proto.crease_edges_size(); k += 2) {
    tags.edges.push_back({static_cast<int32_t>(proto.crease_edges(k)),
                          static_cast<int32_t>(proto.crease_edges(k + 1))});
  }
  tags.corners.assign(proto.corners().begin(), proto.corners().end());
  auto mesh = ControlMesh::Create(std::move(vertices), std::move(triangles), std::move(tags));
  if (mesh.ok()) return mesh;
  return absl::DataLossError(absl::StrCat("control mesh: ", mesh.status().message()));
}

}  // namespace cagefit::client
