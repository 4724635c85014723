// Which trace a call belongs to (W3C Trace Context): the id that its lines in the log share with
// those of its caller.
#ifndef CAGEFIT_SERVER_TRANSPORT_TRACE_H_
#define CAGEFIT_SERVER_TRANSPORT_TRACE_H_

#include <grpcpp/server_context.h>

#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace cagefit::server {

// The trace id, 32 lower-case hexadecimal digits, of a `traceparent`; nullopt when that is
// malformed.
std::optional<std::string> ParseTraceparent(absl::string_view traceparent);

// That of the call's one `traceparent`, or a new random one.
std::string TraceIdOf(const grpc::CallbackServerContext& context);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_TRACE_H_
