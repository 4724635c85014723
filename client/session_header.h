// Which session a call is about, for proxies that send each to a server of its own.
#ifndef CAGEFIT_CLIENT_SESSION_HEADER_H_
#define CAGEFIT_CLIENT_SESSION_HEADER_H_

#include <grpcpp/client_context.h>

#include <string>

namespace cagefit::client {

inline constexpr char kSessionHeader[] = "x-session-id";

// An id that a header cannot hold, which no session has, is left out.
void AddSessionHeader(const std::string& session_id, grpc::ClientContext* context);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_SESSION_HEADER_H_
