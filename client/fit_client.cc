#include "client/fit_client.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/apply_reply.h"
#include "client/channel.h"
#include "client/frame_stream_call.h"
#include "client/mesh_from_proto.h"
#include "client/session_header.h"
#include "client/status_from_grpc.h"
#include "core/base/status.h"
#include "grpc/health/v1/health.grpc.pb.h"

namespace cagefit::client {
namespace {

constexpr size_t kMaxUnaryBytes = 1 << 20;  // above it, a request goes by stream
constexpr size_t kChunkBytes = 1 << 20;
constexpr size_t kMaxBlobBytes = size_t{1} << 30;
constexpr int kKeepaliveMs = 20'000, kKeepaliveTimeoutMs = 10'000;
// Of the channel's own connecting. A server that is back is met soon: by default, gRPC pauses for
// up to two minutes.
constexpr int kFirstReconnectMs = 100, kLongestReconnectMs = 500, kConnectTimeoutMs = 5'000;

// The whole of a streamed result. Reader: ClientReader or ClientReaderWriter of chunks.
template <typename Reader>
absl::StatusOr<std::string> ReadBlob(grpc::ClientContext* context, std::unique_ptr<Reader> reader) {
  std::string blob;
  v1::DataChunk chunk;
  while (reader->Read(&chunk)) {
    if (blob.size() + chunk.data().size() > kMaxBlobBytes) {
      context->TryCancel();
      return absl::ResourceExhaustedError(
          absl::StrCat("the server sends more than ", kMaxBlobBytes, " bytes"));
    }
    blob.append(chunk.data());
  }
  RETURN_IF_ERROR(FromGrpc(reader->Finish(), *context));
  if (blob.size() != chunk.total_bytes()) {
    return absl::DataLossError(
        absl::StrCat("received ", blob.size(), " of ", chunk.total_bytes(), " bytes"));
  }
  return blob;
}

// Sends one large message. Writer: of chunks of the given type. Who is not listened to is told by
// Finish.
template <typename Chunk, typename Writer>
void WriteBlob(const std::string& blob, Writer* writer) {
  Chunk chunk;
  chunk.set_total_bytes(blob.size());
  for (size_t sent = 0; sent < blob.size(); sent += kChunkBytes) {
    chunk.set_data(blob.data() + sent, std::min(kChunkBytes, blob.size() - sent));
    if (!writer->Write(chunk)) break;
  }
  writer->WritesDone();
}

// What stands between a channel that does not connect and its server, such as a certificate that is
// not trusted.
std::string WhyNot(v1::Fitting::Stub* stub) {
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + absl::Seconds(1)));
  v1::ListSessionsResponse response;
  return ": " + stub->ListSessions(&context, {}, &response).error_message();
}

}  // namespace

struct FitClient::Connection {
  std::shared_ptr<grpc::Channel> channel;
  std::unique_ptr<v1::Fitting::Stub> stub;
};

absl::StatusOr<std::unique_ptr<FitClient>> FitClient::Connect(const ClientOptions& options) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeoutMs);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kFirstReconnectMs);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kLongestReconnectMs);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, kConnectTimeoutMs);
  // Clients of one process may be on different servers that come and go under one name.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  auto connection = std::make_unique<Connection>();
  ASSIGN_OR_RETURN(connection->channel,
                   OpenChannel(options.address, options.credentials, arguments));
  connection->stub = v1::Fitting::NewStub(connection->channel);
  if (!connection->channel->WaitForConnected(
          absl::ToChronoTime(absl::Now() + options.connect_timeout))) {
    return absl::UnavailableError(
        absl::StrCat("no server answers at ", options.address, " within ",
                     absl::FormatDuration(options.connect_timeout),
                     options.credentials.wants_tls() ? WhyNot(connection->stub.get()) : ""));
  }
  return std::unique_ptr<FitClient>(new FitClient(std::move(connection)));
}

FitClient::FitClient(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}
FitClient::~FitClient() = default;

absl::StatusOr<v1::Session> FitClient::CreateSession(const v1::CreateSessionRequest& request) {
  grpc::ClientContext context;
  v1::Session session;
  if (request.ByteSizeLong() <= kMaxUnaryBytes) {
    RETURN_IF_ERROR(
        FromGrpc(connection_->stub->CreateSession(&context, request, &session), context));
    return session;
  }
  const auto writer = connection_->stub->CreateSessionFromStream(&context, &session);
  WriteBlob<v1::CreateSessionChunk>(request.SerializeAsString(), writer.get());
  RETURN_IF_ERROR(FromGrpc(writer->Finish(), context));
  return session;
}

absl::StatusOr<v1::Session> FitClient::GetSession(const std::string& session_id) {
  grpc::ClientContext context;
  AddSessionHeader(session_id, &context);
  v1::GetSessionRequest request;
  request.set_session_id(session_id);
  v1::Session session;
  RETURN_IF_ERROR(FromGrpc(connection_->stub->GetSession(&context, request, &session), context));
  return session;
}

absl::StatusOr<std::vector<v1::Session>> FitClient::ListSessions() {
  std::vector<v1::Session> sessions;
  v1::ListSessionsRequest request;
  do {
    grpc::ClientContext context;
    v1::ListSessionsResponse page;
    RETURN_IF_ERROR(FromGrpc(connection_->stub->ListSessions(&context, request, &page), context));
    sessions.insert(sessions.end(), page.sessions().begin(), page.sessions().end());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  return sessions;
}

absl::Status FitClient::DeleteSession(const std::string& session_id) {
  grpc::ClientContext context;
  AddSessionHeader(session_id, &context);
  v1::DeleteSessionRequest request;
  request.set_session_id(session_id);
  google::protobuf::Empty response;
  return FromGrpc(connection_->stub->DeleteSession(&context, request, &response), context);
}

absl::StatusOr<ControlMesh> FitClient::GetControlMesh(const v1::GetControlMeshRequest& request) {
  grpc::ClientContext context;
  AddSessionHeader(request.session_id(), &context);
  ASSIGN_OR_RETURN(const std::string blob,
                   ReadBlob(&context, connection_->stub->GetControlMesh(&context, request)));
  v1::ControlMesh mesh;
  if (!mesh.ParseFromString(blob)) return absl::DataLossError("control mesh: cannot be parsed");
  return FromProto(mesh);
}

absl::StatusOr<std::string> FitClient::GetSurface(const v1::GetSurfaceRequest& request) {
  grpc::ClientContext context;
  AddSessionHeader(request.session_id(), &context);
  return ReadBlob(&context, connection_->stub->GetSurface(&context, request));
}

absl::StatusOr<v1::Stencils> FitClient::GetStencils(const v1::GetStencilsRequest& request) {
  grpc::ClientContext context;
  AddSessionHeader(request.session_id(), &context);
  ASSIGN_OR_RETURN(const std::string blob,
                   ReadBlob(&context, connection_->stub->GetStencils(&context, request)));
  v1::Stencils stencils;
  if (!stencils.ParseFromString(blob)) return absl::DataLossError("stencils: cannot be parsed");
  return stencils;
}

absl::StatusOr<v1::EvaluateLossReply> FitClient::EvaluateLoss(
    const v1::EvaluateLossRequest& request) {
  grpc::ClientContext context;
  AddSessionHeader(request.session_id(), &context);
  auto stream = connection_->stub->EvaluateLoss(&context);
  WriteBlob<v1::DataChunk>(request.SerializeAsString(), stream.get());
  ASSIGN_OR_RETURN(const std::string blob, ReadBlob(&context, std::move(stream)));
  v1::EvaluateLossReply reply;
  if (!reply.ParseFromString(blob)) return absl::DataLossError("loss: cannot be parsed");
  return reply;
}

std::unique_ptr<FrameStream> FitClient::StartStream(const std::string& session_id,
                                                    v1::FrameMode mode, absl::Time deadline) {
  return std::unique_ptr<FrameStream>(new FrameStream(
      std::make_unique<FrameStream::Call>(connection_->stub.get(), session_id, mode, deadline)));
}

absl::StatusOr<std::unique_ptr<FrameStream>> FitClient::OpenStream(const std::string& session_id,
                                                                   v1::FrameMode mode) {
  std::unique_ptr<FrameStream> stream = StartStream(session_id, mode);
  RETURN_IF_ERROR(stream->Open());
  return stream;
}

absl::Status FitClient::GetReplies(v1::GetRepliesRequest request,
                                   const std::function<absl::Status(FittedFrame)>& take,
                                   const RetryOptions& retry) {
  RetryPolicy policy(retry);
  DeltaDecoder decoder;  // begins anew with the first fitted frame of each call, which is a key
  while (true) {
    grpc::ClientContext context;
    AddSessionHeader(request.session_id(), &context);
    const auto reader = connection_->stub->GetReplies(&context, request);
    absl::Status refused;
    v1::FrameReply reply;
    while (refused.ok() && reader->Read(&reply)) {
      auto frame = ApplyReply(std::move(reply), &decoder);
      refused = frame.ok() ? take(*std::move(frame)) : frame.status();
      policy.Progress();
      request.set_first(request.first() + 1);
      if (request.has_count()) request.set_count(request.count() - 1);
    }
    if (!refused.ok()) context.TryCancel();
    while (reader->Read(&reply)) {  // gRPC wants all of it to be read
    }
    const absl::Status ended = FromGrpc(reader->Finish(), context);
    if (!refused.ok() || ended.ok()) return refused;
    if (request.has_count() && request.count() == 0) return absl::OkStatus();
    const std::optional<absl::Duration> pause = policy.PauseAfter(ended);
    if (!pause.has_value()) return ended;
    absl::SleepFor(*pause);
  }
}

absl::StatusOr<bool> FitClient::IsServing(const std::string& service, absl::Duration timeout) {
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + timeout));
  grpc::health::v1::HealthCheckRequest request;
  grpc::health::v1::HealthCheckResponse response;
  request.set_service(service);
  const auto stub = grpc::health::v1::Health::NewStub(connection_->channel);
  RETURN_IF_ERROR(FromGrpc(stub->Check(&context, request, &response), context));
  return response.status() == grpc::health::v1::HealthCheckResponse::SERVING;
}

}  // namespace cagefit::client
