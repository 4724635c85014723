// Sessions, their options and control meshes: between protobuf and the session's structs.
#ifndef CAGEFIT_SERVER_TRANSPORT_SESSION_CONVERT_H_
#define CAGEFIT_SERVER_TRANSPORT_SESSION_CONVERT_H_

#include "absl/status/statusor.h"
#include "cagefit/v1/fitting.pb.h"
#include "core/mesh/control_mesh.h"
#include "server/session/session_config.h"
#include "server/session/session_ledger.h"

namespace cagefit::server {

// Options that are not set take the defaults. INVALID_ARGUMENT naming field and value,
// RESOURCE_EXHAUSTED for a control mesh above the limit.
absl::StatusOr<SessionConfig> FromProto(const v1::CreateSessionRequest& request,
                                        const SessionLimits& limits);

// INVALID_ARGUMENT, reason INVALID_CONTROL_MESH; RESOURCE_EXHAUSTED.
absl::StatusOr<ControlMesh> FromProto(const v1::ControlMesh& proto, const SessionLimits& limits);

v1::Session ToProto(const SessionLedger& ledger);

// Every option in force.
v1::SessionOptions ToProto(const SessionConfig& config);

v1::ControlMesh ToProto(const ControlMesh& mesh);

// Without vertices: what a client needs beside the deltas.
v1::ControlMesh ConnectivityToProto(const ControlMesh& mesh);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_SESSION_CONVERT_H_
