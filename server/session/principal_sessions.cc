#include "server/session/principal_sessions.h"

#include <cmath>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {

absl::StatusOr<std::shared_ptr<SessionLedger>> PrincipalSessions::Create(SessionConfig config,
                                                                         absl::Time now) const {
  return store_->Create(*principal_, std::move(config), now);
}

absl::StatusOr<std::shared_ptr<SessionLedger>> PrincipalSessions::Find(
    const std::string& id) const {
  ASSIGN_OR_RETURN(std::shared_ptr<SessionLedger> ledger, store_->Find(id));
  if (ledger->owner() != principal_->name) return NoSession(id);
  return ledger;
}

absl::StatusOr<std::vector<std::shared_ptr<SessionLedger>>> PrincipalSessions::List(
    const std::string& after, size_t count) const {
  return store_->List(principal_->name, after, count);
}

absl::StatusOr<SessionStore::OpenedStream> PrincipalSessions::OpenStream(
    const std::string& id, const SessionLedger::EndStreamFn& end_stream) const {
  RETURN_IF_ERROR(Find(id).status());
  return store_->OpenStream(id, end_stream);
}

absl::Status PrincipalSessions::Delete(const std::string& id) const {
  RETURN_IF_ERROR(Find(id).status());
  return store_->Delete(id);
}

absl::StatusOr<SessionLease> PrincipalSessions::Lease(const std::string& id) const {
  RETURN_IF_ERROR(Find(id).status());
  return store_->Lease(id);
}

absl::Duration PrincipalSessions::Receive(int64_t bytes) const {
  const std::optional<int64_t>& rate = principal_->quotas.bytes_per_second;
  if (!rate.has_value()) return absl::ZeroDuration();
  return principal_->rate->Take(bytes, *rate, absl::Now());
}

absl::Status PrincipalSessions::CheckRate() const {
  const absl::Duration wait = Receive(0);
  if (wait <= absl::ZeroDuration()) return absl::OkStatus();
  const std::string limit = absl::StrCat(*principal_->quotas.bytes_per_second);
  return WithDetail(absl::ResourceExhaustedError(absl::StrCat(
                        "more bytes per second than the ", limit, " of ", principal_->name,
                        "; try again in ", std::ceil(absl::ToDoubleSeconds(wait)), " s")),
                    {"RATE_EXCEEDED", "bytes per second", "", limit, wait});
}

absl::Status PrincipalSessions::RunFit(const FitShare::SubmitFn& submit, FitShare::Task task,
                                       FitShare::RefusedFn refused) const {
  if (!principal_->quotas.fits.has_value()) return submit(std::move(task));
  return principal_->fits->Run(*principal_->quotas.fits, submit, std::move(task),
                               std::move(refused));
}

}  // namespace cagefit::server
