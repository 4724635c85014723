#include "client/commands/pull_frames.h"

#include <iostream>
#include <utility>

#include "client/commands/fit_report.h"
#include "client/commands/fitted_meshes.h"
#include "client/commands/message_json.h"
#include "client/io/file_bytes.h"
#include "core/base/status.h"

namespace cagefit::client {

absl::Status PullFrames(FitClient* client, const std::string& session_id, const std::string& folder,
                        const SequenceFormats& formats) {
  FitReport report;
  ASSIGN_OR_RETURN(report.session, client->GetSession(session_id));
  RETURN_IF_ERROR(MakeFolder(folder));
  FittedMeshes meshes(client, session_id, folder);
  v1::GetRepliesRequest request;
  request.set_session_id(session_id);
  RETURN_IF_ERROR(client->GetReplies(request, [&](FittedFrame frame) -> absl::Status {
    const uint64_t number = frame.reply.sequence_number();
    FrameRecord& record = report.frames.emplace_back();
    RETURN_IF_ERROR(meshes.Take(std::move(frame), &record));
    if (!record.status.ok()) return absl::OkStatus();
    RETURN_IF_ERROR(meshes.Write(number, record));
    // They are written; all together could fill the memory.
    if (formats.names.empty()) record.control_vertices = Points3d();
    return absl::OkStatus();
  }));
  report.diagonal = SampledDiagonal(report);
  report.settings = {{"options", ToJson(report.session.options())}};
  RETURN_IF_ERROR(WriteFileBytes(folder + "/report.json", Text(ReportJson(report), 2)));
  if (meshes.cage().has_value()) {
    RETURN_IF_ERROR(WriteSequence(formats, *meshes.cage(), report.frames, folder, folder));
  }
  std::cout << folder << ": control meshes of " << Totals(report).fitted << " of "
            << report.frames.size() << " frames, and report.json\n";
  return absl::OkStatus();
}

}  // namespace cagefit::client
