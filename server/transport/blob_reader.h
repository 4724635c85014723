// Receives one large request in chunks.
#ifndef CAGEFIT_SERVER_TRANSPORT_BLOB_READER_H_
#define CAGEFIT_SERVER_TRANSPORT_BLOB_READER_H_

#include <grpcpp/grpcpp.h>

#include <functional>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "cagefit/v1/fitting.pb.h"
#include "server/transport/call_record.h"
#include "server/transport/incoming_blob.h"
#include "server/transport/service_state.h"

namespace cagefit::server {

// Deletes itself when gRPC is done with it.
class BlobReader : public grpc::ServerReadReactor<v1::CreateSessionChunk> {
 public:
  using TakeFn = std::function<absl::Status(const PrincipalSessions&, const std::string&)>;

  // `take` gets the whole and runs in the scheduler's pool for requests.
  static BlobReader* Start(const ServiceState& state, grpc::CallbackServerContext* context,
                           const char* method, TakeFn take);

  void OnReadDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  BlobReader(const ServiceState& state, grpc::CallbackServerContext* context, const char* method,
             TakeFn take);
  absl::Status Enter();
  void End();

  const ServiceState& state_;
  grpc::CallbackServerContext* const context_;
  CallRecord record_;
  const TakeFn take_;
  std::optional<PrincipalSessions> sessions_;
  v1::CreateSessionChunk chunk_;
  IncomingBlob blob_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_BLOB_READER_H_
