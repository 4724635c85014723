// Control meshes between protobuf and core.
#ifndef CAGEFIT_CLIENT_MESH_FROM_PROTO_H_
#define CAGEFIT_CLIENT_MESH_FROM_PROTO_H_

#include "absl/status/statusor.h"
#include "cagefit/v1/fitting.pb.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::client {

v1::ControlMesh ToProto(const ControlMesh& mesh);

// DATA_LOSS when it is not a valid control mesh.
absl::StatusOr<ControlMesh> FromProto(const v1::ControlMesh& proto);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_MESH_FROM_PROTO_H_
