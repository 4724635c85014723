// Who calls, and which sessions there are for them.
#ifndef CAGEFIT_SERVER_TRANSPORT_AUTH_H_
#define CAGEFIT_SERVER_TRANSPORT_AUTH_H_

#include <grpcpp/server_context.h>

#include <memory>

#include "absl/status/statusor.h"
#include "server/session/principal_sessions.h"
#include "server/session/token_file.h"

namespace cagefit::server {

// The only way to sessions. Thread-safe; does nothing that blocks.
class Auth {
 public:
  // Both must outlive it. `tokens` may be null: then nobody needs one.
  Auth(SessionStore* store, const TokenFile* tokens) : store_(store), tokens_(tokens) {}

  // With tokens, the principal is that of the call's "authorization: Bearer TOKEN". Without, it is
  // the common name of the client's certificate, or the first of its alternative names, where the
  // connection has one, else the principal with the empty name, who is the same for all.
  // UNAUTHENTICATED, reason NO_VALID_CREDENTIALS, whatever it is that is missing or wrong.
  absl::StatusOr<PrincipalSessions> Enter(const grpc::CallbackServerContext& context) const;

  // Of everybody.
  const SessionLimits& session_limits() const { return store_->session_limits(); }

 private:
  SessionStore* const store_;
  const TokenFile* const tokens_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_AUTH_H_
