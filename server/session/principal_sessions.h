// The store as one call sees it: bound to the principal that calls. Calls have this and never the
// store, so none can forget to ask whose a session is.
#ifndef CAGEFIT_SERVER_SESSION_PRINCIPAL_SESSIONS_H_
#define CAGEFIT_SERVER_SESSION_PRINCIPAL_SESSIONS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/session/principal.h"
#include "server/session/session_store.h"

namespace cagefit::server {

// To a principal, the sessions of others do not exist: the errors are those for an id that nobody
// has. Otherwise as the store's. Cheap to copy; thread-safe.
class PrincipalSessions {
 public:
  // `store` must outlive it.
  PrincipalSessions(SessionStore* store, std::shared_ptr<const Principal> principal)
      : store_(store), principal_(std::move(principal)) {}

  const SessionLimits& limits() const { return store_->session_limits(); }

  absl::StatusOr<std::shared_ptr<SessionLedger>> Create(SessionConfig config, absl::Time now) const;
  absl::StatusOr<std::shared_ptr<SessionLedger>> Find(const std::string& id) const;
  absl::StatusOr<std::vector<std::shared_ptr<SessionLedger>>> List(const std::string& after,
                                                                   size_t count) const;
  absl::StatusOr<SessionStore::OpenedStream> OpenStream(
      const std::string& id, const SessionLedger::EndStreamFn& end_stream) const;
  absl::Status Delete(const std::string& id) const;
  absl::StatusOr<SessionLease> Lease(const std::string& id) const;

  // Counts bytes that have arrived. Returns how long the principal has to wait before it sends
  // more.
  absl::Duration Receive(int64_t bytes) const;
  // RESOURCE_EXHAUSTED, reason RATE_EXCEEDED, saying when to come back, while Receive would have
  // the principal wait.
  absl::Status CheckRate() const;

  // As FitShare::Run; without a quota, submits at once.
  absl::Status RunFit(const FitShare::SubmitFn& submit, FitShare::Task task,
                      FitShare::RefusedFn refused) const;

 private:
  SessionStore* store_;
  std::shared_ptr<const Principal> principal_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_PRINCIPAL_SESSIONS_H_
