// Replies of a session as what a report keeps of them, and as files of control meshes.
#ifndef CAGEFIT_CLIENT_COMMANDS_FITTED_MESHES_H_
#define CAGEFIT_CLIENT_COMMANDS_FITTED_MESHES_H_

#include <cstddef>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "client/commands/fit_report.h"
#include "client/fit_client.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::client {

class FittedMeshes {
 public:
  // `client` must outlive it. Files go to `folder`, which must be there. `cage`: the session's
  // template, where it is known.
  FittedMeshes(FitClient* client, std::string session_id, std::string folder,
               std::optional<ControlMesh> cage = std::nullopt);

  // Its connectivity is that of every frame; there is one when a frame was fitted.
  const std::optional<ControlMesh>& cage() const { return cage_; }

  // Fills the record. Errors of the server, which may have to be asked for the control mesh.
  absl::Status Take(FittedFrame frame, FrameRecord* record);

  // NNNN.obj of a fitted frame.
  absl::Status Write(size_t number, const FrameRecord& record) const;

 private:
  absl::StatusOr<ControlMesh> FindCage(const FittedFrame& frame) const;

  FitClient* const client_;
  const std::string session_id_, folder_;
  std::optional<ControlMesh> cage_;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_COMMANDS_FITTED_MESHES_H_
