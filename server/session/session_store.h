// The sessions of this server, in memory.
#ifndef CAGEFIT_SERVER_SESSION_SESSION_STORE_H_
#define CAGEFIT_SERVER_SESSION_SESSION_STORE_H_

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/session/session.h"

namespace cagefit::server {

// The right to use a session, until it is destroyed. Keeps the session alive.
class SessionLease {
 public:
  SessionLease(SessionLease&&) = default;
  SessionLease& operator=(SessionLease&&) = delete;
  ~SessionLease();

  Session* operator->() const { return &entry_->session; }

 private:
  friend class SessionStore;
  struct Entry {
    Entry(std::shared_ptr<SessionLedger> ledger, TemplateMaker* templates, ClockFn clock)
        : session(std::move(ledger), templates, std::move(clock)) {}
    Session session;
    std::atomic<bool> leased{false};
  };
  explicit SessionLease(std::shared_ptr<Entry> entry) : entry_(std::move(entry)) {}

  std::shared_ptr<Entry> entry_;
};

// Thread-safe.
class SessionStore {
 public:
  struct Limits {
    int64_t max_sessions = 1000;
    SessionLimits session;
  };

  // `templates` must outlive the store and every lease.
  SessionStore(const Limits& limits, TemplateMaker* templates, ClockFn clock);

  const SessionLimits& session_limits() const { return limits_.session; }

  // INVALID_ARGUMENT for a bad config, RESOURCE_EXHAUSTED naming the limit, FAILED_PRECONDITION
  // when templates cannot be made here.
  absl::StatusOr<std::shared_ptr<SessionLedger>> Create(SessionConfig config, absl::Time now);

  // NOT_FOUND naming the id.
  absl::StatusOr<std::shared_ptr<SessionLedger>> Find(const std::string& id) const;

  // At most `count` sessions in order of id, the first one after `after`.
  std::vector<std::shared_ptr<SessionLedger>> List(const std::string& after, size_t count) const;

  // Ends the session's stream; memory goes once the last lease does.
  absl::Status Delete(const std::string& id);

  // NOT_FOUND; UNAVAILABLE while another lease is held: callers take turns through the scheduler.
  absl::StatusOr<SessionLease> Lease(const std::string& id);

 private:
  using Entry = SessionLease::Entry;

  const Limits limits_;
  TemplateMaker* const templates_;
  const ClockFn clock_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<Entry>> entries_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_SESSION_STORE_H_
