// Statuses on the wire: same codes as absl, details in the "cagefit-error-detail-bin" trailer.
#ifndef CAGEFIT_SERVER_TRANSPORT_STATUS_CONVERT_H_
#define CAGEFIT_SERVER_TRANSPORT_STATUS_CONVERT_H_

#include <grpcpp/server_context.h>
#include <grpcpp/support/status.h>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "cagefit/v1/fitting.pb.h"

namespace cagefit::server {

inline constexpr char kErrorDetailTrailer[] = "cagefit-error-detail-bin";

// Adds the detail, if any, to `context`'s trailers: call once, before the call is finished.
grpc::Status ToGrpc(const absl::Status& status, grpc::CallbackServerContext* context);

// `status`, or DEADLINE_EXCEEDED where it is CANCELLED and the call's deadline is the cause.
absl::Status NamingDeadline(const absl::Status& status, absl::Time deadline);
// Of a call that gRPC says is cancelled.
absl::Status CancelledCall(const grpc::CallbackServerContext& context);

v1::FrameError ToProto(const absl::Status& status);
absl::Status FromProto(const v1::FrameError& error);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_STATUS_CONVERT_H_
