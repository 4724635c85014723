#include "server/transport/service.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"
#include "server/session/stencil_export.h"
#include "server/session/surface_export.h"
#include "server/transport/blob_reader.h"
#include "server/transport/blob_writer.h"
#include "server/transport/call_record.h"
#include "server/transport/evaluate_loss_call.h"
#include "server/transport/fit_frames_call.h"
#include "server/transport/get_replies_call.h"
#include "server/transport/loss_convert.h"
#include "server/transport/message_parts.h"
#include "server/transport/session_convert.h"
#include "server/transport/status_convert.h"

namespace cagefit::server {
namespace {

constexpr uint32_t kMaxPageSize = 1000;
// Whoever sends more than they may can still see their sessions, and delete them.
constexpr int64_t kSmallRequestBytes = 4096;
constexpr size_t kMaxPageBytes = 3 << 20;  // sessions have cameras: up to some 25 KB each

using UnaryFn = std::function<absl::Status(const PrincipalSessions&)>;

absl::Status Queue(const ServiceState& state, const grpc::CallbackServerContext& context,
                   int64_t request_bytes, std::function<void(const PrincipalSessions&)> task) {
  ASSIGN_OR_RETURN(const PrincipalSessions sessions, state.auth->Enter(context));
  if (request_bytes > kSmallRequestBytes) RETURN_IF_ERROR(sessions.CheckRate());
  sessions.Receive(request_bytes);
  return state.scheduler->queries.Run(context.peer(),
                                      [sessions, task = std::move(task)] { task(sessions); });
}

// Answers from a pool: `work` may take its time.
grpc::ServerUnaryReactor* RunUnary(const ServiceState& state, grpc::CallbackServerContext* context,
                                   const char* method, int64_t request_bytes, UnaryFn work) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  const auto record = std::make_shared<CallRecord>(state, context, method);
  const absl::Status queued =
      Queue(state, *context, request_bytes,
            [reactor, context, record, work = std::move(work)](const PrincipalSessions& sessions) {
              reactor->Finish(
                  record->End(context->IsCancelled() ? CancelledCall(*context) : work(sessions)));
            });
  if (!queued.ok()) reactor->Finish(record->End(queued));
  return reactor;
}

absl::Status Create(const ServiceState& state, const PrincipalSessions& sessions,
                    const v1::CreateSessionRequest& request, v1::Session* session) {
  RETURN_IF_ERROR(state.streams->CheckServing());
  ASSIGN_OR_RETURN(SessionConfig config, FromProto(request, sessions.limits()));
  ASSIGN_OR_RETURN(const auto ledger, sessions.Create(std::move(config), absl::Now()));
  *session = ToProto(*ledger);
  return absl::OkStatus();
}

absl::StatusOr<ControlMesh> FindMesh(const SessionLedger& ledger,
                                     const v1::GetControlMeshRequest& request) {
  switch (request.which_case()) {
    case v1::GetControlMeshRequest::kSequenceNumber:
      return ledger.MeshOfFrame(request.sequence_number());
    case v1::GetControlMeshRequest::kTemplate:
      if (request.template_()) return ledger.TemplateMesh();
      break;
    case v1::GetControlMeshRequest::WHICH_NOT_SET:
      break;
  }
  return ledger.LatestMesh();
}

// What refining takes, and what is made of it, a triangle: rows of the stencils, the mesh, and the
// coder's tables.
constexpr int64_t kExportBytesPerTriangle = 400;

// The memory for `levels` refinements, for as long as they take. Above the limit on triangles, it
// is that which is refused.
absl::StatusOr<MemoryReservation> ReserveExport(const ServiceState& state,
                                                const PrincipalSessions& sessions,
                                                const ControlMesh& mesh, uint32_t levels) {
  MemoryReservation reservation(state.budget);
  const int64_t triangles = int64_t{mesh.topology().triangle_count()} << (2 * std::min(levels, 5u));
  if (triangles <= sessions.limits().max_surface_triangles) {
    RETURN_IF_ERROR(reservation.Grow(kExportBytesPerTriangle * triangles));
  }
  return reservation;
}

absl::StatusOr<std::string> Surface(const ServiceState& state, const PrincipalSessions& sessions,
                                    const v1::GetSurfaceRequest& request) {
  ASSIGN_OR_RETURN(const auto ledger, sessions.Find(request.session_id()));
  SurfaceExportOptions options;
  options.max_triangles = sessions.limits().max_surface_triangles;
  if (request.has_levels()) options.levels = request.levels();
  if (request.has_position_bits()) {
    options.position_bits = request.position_bits();
    if (options.position_bits == 0) {
      return InvalidField("position_bits", "0", "expected 8 to 30, or not set");
    }
  }
  ASSIGN_OR_RETURN(const ControlMesh mesh, request.has_sequence_number()
                                               ? ledger->MeshOfFrame(request.sequence_number())
                                               : ledger->LatestMesh());
  ASSIGN_OR_RETURN(const MemoryReservation memory,
                   ReserveExport(state, sessions, mesh, options.levels));
  return ExportSurface(mesh, options);
}

absl::StatusOr<std::string> Stencils(const ServiceState& state, const PrincipalSessions& sessions,
                                     const v1::GetStencilsRequest& request) {
  ASSIGN_OR_RETURN(const auto ledger, sessions.Find(request.session_id()));
  ASSIGN_OR_RETURN(const ControlMesh mesh, ledger->FinalTemplate());
  StencilExportOptions options;
  options.max_triangles = sessions.limits().max_surface_triangles;
  if (request.has_levels()) options.levels = request.levels();
  ASSIGN_OR_RETURN(const MemoryReservation memory,
                   ReserveExport(state, sessions, mesh, options.levels.value_or(1)));
  ASSIGN_OR_RETURN(const ExportedStencils stencils,
                   ExportStencils(mesh, ledger->config().fit.distance, options));
  return ToProto(stencils).SerializeAsString();
}

}  // namespace

grpc::ServerUnaryReactor* FittingService::CreateSession(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request,
                                                        grpc::ByteBuffer* session) {
  return RunUnary(state_, context, "CreateSession", static_cast<int64_t>(request->Length()),
                  [this, request, session](const PrincipalSessions& sessions) -> absl::Status {
                    v1::CreateSessionRequest parsed;
                    RETURN_IF_ERROR(ParseParts("request", *request, &parsed));
                    v1::Session created;
                    RETURN_IF_ERROR(Create(state_, sessions, parsed, &created));
                    *session = Serialized(created);
                    return absl::OkStatus();
                  });
}

grpc::ServerReadReactor<v1::CreateSessionChunk>* FittingService::CreateSessionFromStream(
    grpc::CallbackServerContext* context, v1::Session* session) {
  return BlobReader::Start(
      state_, context, "CreateSessionFromStream",
      [this, session](const PrincipalSessions& sessions, const std::string& blob) {
        // Of numbers of a byte each, parsing makes eight times as much.
        MemoryReservation parsed(state_.budget);
        RETURN_IF_ERROR(parsed.Grow(8 * static_cast<int64_t>(blob.size())));
        v1::CreateSessionRequest request;
        RETURN_IF_ERROR(ParseParts("data", blob, &request));
        return Create(state_, sessions, request, session);
      });
}

grpc::ServerUnaryReactor* FittingService::GetSession(grpc::CallbackServerContext* context,
                                                     const v1::GetSessionRequest* request,
                                                     v1::Session* session) {
  return RunUnary(state_, context, "GetSession", static_cast<int64_t>(request->ByteSizeLong()),
                  [request, session](const PrincipalSessions& sessions) -> absl::Status {
                    ASSIGN_OR_RETURN(const auto ledger, sessions.Find(request->session_id()));
                    *session = ToProto(*ledger);
                    return absl::OkStatus();
                  });
}

grpc::ServerUnaryReactor* FittingService::ListSessions(grpc::CallbackServerContext* context,
                                                       const v1::ListSessionsRequest* request,
                                                       v1::ListSessionsResponse* response) {
  return RunUnary(
      state_, context, "ListSessions", static_cast<int64_t>(request->ByteSizeLong()),
      [request, response](const PrincipalSessions& sessions) -> absl::Status {
        const uint32_t size =
            request->page_size() == 0 ? kMaxPageSize : std::min(request->page_size(), kMaxPageSize);
        // The token is the last id of the page before: it stays good when sessions come and go.
        ASSIGN_OR_RETURN(const auto page, sessions.List(request->page_token(), size + 1));
        size_t bytes = 0;
        for (size_t k = 0; k < page.size(); ++k) {
          v1::Session session = ToProto(*page[k]);
          bytes += session.ByteSizeLong();
          if (k == size || (k > 0 && bytes > kMaxPageBytes)) {
            response->set_next_page_token(page[k - 1]->id());
            break;
          }
          *response->add_sessions() = std::move(session);
        }
        return absl::OkStatus();
      });
}

grpc::ServerUnaryReactor* FittingService::DeleteSession(grpc::CallbackServerContext* context,
                                                        const v1::DeleteSessionRequest* request,
                                                        google::protobuf::Empty*) {
  return RunUnary(state_, context, "DeleteSession", static_cast<int64_t>(request->ByteSizeLong()),
                  [request](const PrincipalSessions& sessions) {
                    return sessions.Delete(request->session_id());
                  });
}

grpc::ServerWriteReactor<v1::DataChunk>* FittingService::GetControlMesh(
    grpc::CallbackServerContext* context, const v1::GetControlMeshRequest* request) {
  return BlobWriter::Start(
      state_, context, "GetControlMesh",
      [request](const PrincipalSessions& sessions) -> absl::StatusOr<std::string> {
        ASSIGN_OR_RETURN(const auto ledger, sessions.Find(request->session_id()));
        ASSIGN_OR_RETURN(const ControlMesh mesh, FindMesh(*ledger, *request));
        return ToProto(mesh).SerializeAsString();
      });
}

grpc::ServerWriteReactor<v1::DataChunk>* FittingService::GetSurface(
    grpc::CallbackServerContext* context, const v1::GetSurfaceRequest* request) {
  return BlobWriter::Start(state_, context, "GetSurface",
                           [this, request](const PrincipalSessions& sessions) {
                             return Surface(state_, sessions, *request);
                           });
}

grpc::ServerWriteReactor<v1::DataChunk>* FittingService::GetStencils(
    grpc::CallbackServerContext* context, const v1::GetStencilsRequest* request) {
  return BlobWriter::Start(state_, context, "GetStencils",
                           [this, request](const PrincipalSessions& sessions) {
                             return Stencils(state_, sessions, *request);
                           });
}

grpc::ServerBidiReactor<v1::DataChunk, v1::DataChunk>* FittingService::EvaluateLoss(
    grpc::CallbackServerContext* context) {
  return EvaluateLossCall::Start(state_, context);
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* FittingService::FitFrames(
    grpc::CallbackServerContext* context) {
  return FitFramesCall::Start(&state_, context);
}

grpc::ServerWriteReactor<v1::FrameReply>* FittingService::GetReplies(
    grpc::CallbackServerContext* context, const v1::GetRepliesRequest* request) {
  return GetRepliesCall::Start(state_, context, request);
}

}  // namespace cagefit::server
