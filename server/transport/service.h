// cagefit.v1.Fitting on gRPC's callback API. Reactions only hand work over; see fit_frames_call.h.
#ifndef CAGEFIT_SERVER_TRANSPORT_SERVICE_H_
#define CAGEFIT_SERVER_TRANSPORT_SERVICE_H_

#include "cagefit/v1/fitting.grpc.pb.h"
#include "server/transport/service_state.h"

namespace cagefit::server {

// Where a message may be large, it comes in bytes: gRPC would parse any number of parts.
using RawMethods = v1::Fitting::WithRawCallbackMethod_CreateSession<
    v1::Fitting::WithRawCallbackMethod_FitFrames<v1::Fitting::Service>>;
using AllMethods = v1::Fitting::WithCallbackMethod_CreateSessionFromStream<
    v1::Fitting::WithCallbackMethod_GetSession<
        v1::Fitting::WithCallbackMethod_ListSessions<v1::Fitting::WithCallbackMethod_DeleteSession<
            v1::Fitting::WithCallbackMethod_GetControlMesh<
                v1::Fitting::WithCallbackMethod_GetSurface<
                    v1::Fitting::WithCallbackMethod_GetStencils<
                        v1::Fitting::WithCallbackMethod_EvaluateLoss<
                            v1::Fitting::WithCallbackMethod_GetReplies<RawMethods>>>>>>>>>;

class FittingService final : public AllMethods {
 public:
  explicit FittingService(ServiceState state) : state_(std::move(state)) {}

  grpc::ServerUnaryReactor* CreateSession(grpc::CallbackServerContext* context,
                                          const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* session) override;
  grpc::ServerReadReactor<v1::CreateSessionChunk>* CreateSessionFromStream(
      grpc::CallbackServerContext* context, v1::Session* session) override;
  grpc::ServerUnaryReactor* GetSession(grpc::CallbackServerContext* context,
                                       const v1::GetSessionRequest* request,
                                       v1::Session* session) override;
  grpc::ServerUnaryReactor* ListSessions(grpc::CallbackServerContext* context,
                                         const v1::ListSessionsRequest* request,
                                         v1::ListSessionsResponse* response) override;
  grpc::ServerUnaryReactor* DeleteSession(grpc::CallbackServerContext* context,
                                          const v1::DeleteSessionRequest* request,
                                          google::protobuf::Empty* response) override;
  grpc::ServerWriteReactor<v1::DataChunk>* GetControlMesh(
      grpc::CallbackServerContext* context, const v1::GetControlMeshRequest* request) override;
  grpc::ServerWriteReactor<v1::DataChunk>* GetSurface(
      grpc::CallbackServerContext* context, const v1::GetSurfaceRequest* request) override;
  grpc::ServerWriteReactor<v1::DataChunk>* GetStencils(
      grpc::CallbackServerContext* context, const v1::GetStencilsRequest* request) override;
  grpc::ServerBidiReactor<v1::DataChunk, v1::DataChunk>* EvaluateLoss(
      grpc::CallbackServerContext* context) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* FitFrames(
      grpc::CallbackServerContext* context) override;
  grpc::ServerWriteReactor<v1::FrameReply>* GetReplies(
      grpc::CallbackServerContext* context, const v1::GetRepliesRequest* request) override;

 private:
  const ServiceState state_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_SERVICE_H_
