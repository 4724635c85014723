#include "server/session/session_store.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/digest.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

absl::Status NoSession(const std::string& id) {
  return WithDetail(absl::NotFoundError(absl::StrCat("session_id is \"", id, "\"; there is none")),
                    {"NO_SESSION", "session_id", id, ""});
}

}  // namespace

SessionLease::~SessionLease() {
  if (entry_ != nullptr) entry_->leased.store(false, std::memory_order_release);
}

SessionStore::SessionStore(const Limits& limits, TemplateMaker* templates, ClockFn clock)
    : limits_(limits), templates_(templates), clock_(std::move(clock)) {}

absl::StatusOr<std::shared_ptr<SessionLedger>> SessionStore::Create(SessionConfig config,
                                                                    absl::Time now) {
  RETURN_IF_ERROR(config.Validate());
  const int32_t vertices = config.control_mesh.has_value() ? config.control_mesh->vertex_count()
                                                           : config.make_template.vertices;
  if (vertices > limits_.session.max_control_vertices) {
    return LimitExceeded("control vertices", vertices, limits_.session.max_control_vertices);
  }
  int64_t pixels = 0;
  for (const Camera& camera : config.cameras) {
    pixels += static_cast<int64_t>(camera.width) * camera.height;
  }
  if (pixels > limits_.session.max_camera_pixels) {
    return LimitExceeded("pixels of all cameras", pixels, limits_.session.max_camera_pixels);
  }
  if (!config.control_mesh.has_value()) RETURN_IF_ERROR(templates_->CheckAvailable());

  auto ledger =
      std::make_shared<SessionLedger>(RandomId(), std::move(config), limits_.session, now);
  auto entry = std::make_shared<Entry>(ledger, templates_, clock_);
  std::lock_guard<std::mutex> lock(mutex_);
  const int64_t sessions = static_cast<int64_t>(entries_.size());
  if (sessions >= limits_.max_sessions) {
    return LimitExceeded("sessions", sessions + 1, limits_.max_sessions);
  }
  entries_.emplace(ledger->id(), std::move(entry));
  return ledger;
}

absl::StatusOr<std::shared_ptr<SessionLedger>> SessionStore::Find(const std::string& id) const {
  std::lock_guard<std::mutex> lock(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return NoSession(id);
  return found->second->session.ledger();
}

std::vector<std::shared_ptr<SessionLedger>> SessionStore::List(const std::string& after,
                                                               size_t count) const {
  std::vector<std::shared_ptr<SessionLedger>> page;
  std::lock_guard<std::mutex> lock(mutex_);
  for (auto e = entries_.upper_bound(after); e != entries_.end() && page.size() < count; ++e) {
    page.push_back(e->second->session.ledger());
  }
  return page;
}

absl::Status SessionStore::Delete(const std::string& id) {
  std::shared_ptr<Entry> entry;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    const auto found = entries_.find(id);
    if (found == entries_.end()) return NoSession(id);
    entry = std::move(found->second);
    entries_.erase(found);
  }
  entry->session.ledger()->Delete();
  return absl::OkStatus();
}

absl::StatusOr<SessionLease> SessionStore::Lease(const std::string& id) {
  std::shared_ptr<Entry> entry;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    const auto found = entries_.find(id);
    if (found == entries_.end()) return NoSession(id);
    entry = found->second;
  }
  if (entry->leased.exchange(true, std::memory_order_acquire)) {
    return absl::UnavailableError(absl::StrCat("session ", id, " is in use"));
  }
  return SessionLease(std::move(entry));
}

}  // namespace cagefit::server
