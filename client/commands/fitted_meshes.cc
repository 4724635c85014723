#include "client/commands/fitted_meshes.h"

#include <utility>

#include "absl/strings/str_format.h"
#include "client/io/geometry_file.h"
#include "client/mesh_from_proto.h"
#include "core/base/status.h"

namespace cagefit::client {

FittedMeshes::FittedMeshes(FitClient* client, std::string session_id, std::string folder,
                           std::optional<ControlMesh> cage)
    : client_(client),
      session_id_(std::move(session_id)),
      folder_(std::move(folder)),
      cage_(std::move(cage)) {}

absl::Status FittedMeshes::Take(FittedFrame frame, FrameRecord* record) {
  record->status = frame.status;
  record->delta_bytes = static_cast<int64_t>(frame.reply.delta().ByteSizeLong());
  if (frame.status.ok()) {
    if (!cage_.has_value()) {
      ASSIGN_OR_RETURN(cage_, FindCage(frame));
    }
    record->control_vertices = std::move(frame.control_vertices);
  }
  record->reply = std::move(frame.reply);
  record->reply.clear_delta();
  record->reply.clear_template_();
  return absl::OkStatus();
}

absl::Status FittedMeshes::Write(size_t number, const FrameRecord& record) const {
  return WriteControlMesh(absl::StrFormat("%s/%04d.obj", folder_, number),
                          cage_->WithVertices(record.control_vertices));
}

absl::StatusOr<ControlMesh> FittedMeshes::FindCage(const FittedFrame& frame) const {
  if (frame.reply.has_template_()) {
    v1::ControlMesh mesh = frame.reply.template_();
    mesh.mutable_vertices()->Assign(frame.control_vertices.data(),
                                    frame.control_vertices.data() + frame.control_vertices.size());
    return FromProto(mesh);
  }
  v1::GetControlMeshRequest request;
  request.set_session_id(session_id_);
  request.set_template_(true);
  return client_->GetControlMesh(request);
}

}  // namespace cagefit::client
