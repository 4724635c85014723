// What a server's status says to a program here.
#ifndef CAGEFIT_CLIENT_STATUS_FROM_GRPC_H_
#define CAGEFIT_CLIENT_STATUS_FROM_GRPC_H_

#include <grpcpp/client_context.h>
#include <grpcpp/support/status.h>

#include <optional>

#include "absl/status/status.h"
#include "cagefit/v1/fitting.pb.h"

namespace cagefit::client {

// Same code and message; the server's ErrorDetail, if any, rides along. Call it after the call of
// `context` has ended.
absl::Status FromGrpc(const grpc::Status& status, const grpc::ClientContext& context);

// A rejected frame's error.
absl::Status FromProto(const v1::FrameError& error);

// The detail that one of the two above attached.
std::optional<v1::ErrorDetail> DetailOf(const absl::Status& status);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_STATUS_FROM_GRPC_H_
