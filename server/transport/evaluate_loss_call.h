// One EvaluateLoss call: a request in, a reply out, both in chunks.
//
// The request is parsed and its frame decoded in the pool for decodes; the loss is evaluated in
// that for fits, where it takes its turn with the frames of the session.
#ifndef CAGEFIT_SERVER_TRANSPORT_EVALUATE_LOSS_CALL_H_
#define CAGEFIT_SERVER_TRANSPORT_EVALUATE_LOSS_CALL_H_

#include <grpcpp/grpcpp.h>

#include <optional>

#include "cagefit/v1/fitting.pb.h"
#include "server/transport/call_record.h"
#include "server/transport/incoming_blob.h"
#include "server/transport/loss_convert.h"
#include "server/transport/outgoing_blob.h"
#include "server/transport/service_state.h"

namespace cagefit::server {

// Deletes itself when gRPC is done with it.
class EvaluateLossCall : public grpc::ServerBidiReactor<v1::DataChunk, v1::DataChunk> {
 public:
  static EvaluateLossCall* Start(const ServiceState& state, grpc::CallbackServerContext* context);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  EvaluateLossCall(const ServiceState& state, grpc::CallbackServerContext* context);

  absl::Status Enter();
  absl::Status QueueDecode();
  absl::Status Decode();  // in the pool for decodes; queues the evaluation
  absl::StatusOr<Loss> Evaluate() const;
  void Reply();  // in the pool for fits
  void End(const absl::Status& status);

  const ServiceState& state_;
  grpc::CallbackServerContext* const context_;
  std::optional<PrincipalSessions> sessions_;
  CallRecord record_;
  v1::DataChunk chunk_;
  IncomingBlob request_;
  LossQuery query_;
  MemoryReservation decoded_;  // what the frame takes
  OutgoingBlob reply_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_EVALUATE_LOSS_CALL_H_
