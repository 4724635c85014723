// Sends one large result in chunks.
#ifndef CAGEFIT_SERVER_TRANSPORT_BLOB_WRITER_H_
#define CAGEFIT_SERVER_TRANSPORT_BLOB_WRITER_H_

#include <grpcpp/grpcpp.h>

#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "cagefit/v1/fitting.pb.h"
#include "server/transport/call_record.h"
#include "server/transport/outgoing_blob.h"
#include "server/transport/service_state.h"

namespace cagefit::server {

// Deletes itself when gRPC is done with it.
class BlobWriter : public grpc::ServerWriteReactor<v1::DataChunk> {
 public:
  using MakeFn = std::function<absl::StatusOr<std::string>(const PrincipalSessions&)>;

  // `make` runs in the scheduler's pool for requests.
  static BlobWriter* Start(const ServiceState& state, grpc::CallbackServerContext* context,
                           const char* method, MakeFn make);

  void OnWriteDone(bool ok) override;
  void OnDone() override { delete this; }

 private:
  BlobWriter(const ServiceState& state, grpc::CallbackServerContext* context, const char* method)
      : context_(context), record_(state, context, method), blob_(state.budget) {}
  void Begin(absl::StatusOr<std::string> blob);

  grpc::CallbackServerContext* const context_;
  CallRecord record_;
  OutgoingBlob blob_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_BLOB_WRITER_H_
