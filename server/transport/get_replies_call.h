// One GetReplies call: stored replies out, in order.
//
// One reply is in memory at a time: it is made in the pool for requests once the one before is
// written.
#ifndef CAGEFIT_SERVER_TRANSPORT_GET_REPLIES_CALL_H_
#define CAGEFIT_SERVER_TRANSPORT_GET_REPLIES_CALL_H_

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <memory>

#include "cagefit/v1/fitting.pb.h"
#include "server/session/session_ledger.h"
#include "server/transport/call_record.h"
#include "server/transport/service_state.h"

namespace cagefit::server {

// Deletes itself when gRPC is done with it.
class GetRepliesCall : public grpc::ServerWriteReactor<v1::FrameReply> {
 public:
  // `request` lives as long as the call.
  static GetRepliesCall* Start(const ServiceState& state, grpc::CallbackServerContext* context,
                               const v1::GetRepliesRequest* request);

  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  GetRepliesCall(const ServiceState& state, grpc::CallbackServerContext* context,
                 const v1::GetRepliesRequest* request);

  void QueueNext();
  // In the pool.
  void Next();
  absl::Status Begin();
  absl::Status MakeReply();

  const ServiceState& state_;
  grpc::CallbackServerContext* const context_;
  const v1::GetRepliesRequest* const request_;
  CallRecord record_;
  const absl::StatusOr<PrincipalSessions> sessions_;
  std::shared_ptr<SessionLedger> ledger_;  // from the first task on
  uint64_t next_ = 0, end_ = 0;            // sequence numbers
  bool fitted_seen_ = false;               // the client knows a state that deltas refer to
  v1::FrameReply reply_;
  MemoryReservation reservation_;  // what the reply takes
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_GET_REPLIES_CALL_H_
