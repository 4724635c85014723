// The sessions of this server: in a journal, and those in use in memory.
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
#include "absl/time/time.h"
#include "server/session/journal.h"
#include "server/session/memory_account.h"
#include "server/session/principal.h"
#include "server/session/session.h"

namespace cagefit::server {

class SessionStore;

// The right to use a session, until it is destroyed. Keeps the session alive.
class SessionLease {
 public:
  SessionLease(SessionLease&&) = default;
  SessionLease& operator=(SessionLease&&) = delete;
  ~SessionLease();

  Session* operator->() const { return &entry_->session; }

  // Before a fit, or an evaluation of the loss, of a frame of `points` points: takes the memory
  // that the session's model will need, if need be from the models of sessions that are not leased.
  // RESOURCE_EXHAUSTED. What turns out not to be needed is given back with the lease.
  enum class Work { kFit, kEvaluateLoss };
  absl::Status Reserve(Work work, int64_t points);

 private:
  friend class SessionStore;
  enum class Use { kFree, kLeased, kShedding };
  struct Entry {
    Entry(std::shared_ptr<SessionLedger> ledger, TemplateMaker* templates, ClockFn clock,
          MemoryReservation memory)
        : session(std::move(ledger), templates, std::move(clock)), memory(std::move(memory)) {}

    // What the session needs where its model has had frames of `points` points; 0: without one.
    int64_t NeededBytes(int64_t points) const;
    // Gives back what it does not need.
    void Settle();

    Session session;
    std::atomic<Use> use{Use::kFree};
    absl::Time last_used;  // under the store's mutex
    // Of who uses the entry.
    MemoryReservation memory;
    int64_t points = 0;  // of the largest frame that the model has had
    bool evaluates = false;
  };
  SessionLease(SessionStore* store, std::shared_ptr<Entry> entry)
      : store_(store), entry_(std::move(entry)) {}

  SessionStore* store_;
  std::shared_ptr<Entry> entry_;
};

// Knows whose a session is but does not ask: calls come through PrincipalSessions, which does.
// Thread-safe.
class SessionStore {
 public:
  struct Limits {
    int64_t max_sessions = 1000;
    SessionLimits session;
    MemoryAccount* memory = nullptr;  // of all sessions in memory; null: without a limit
  };

  // `journal` and `templates` must outlive the store, every ledger and every lease.
  SessionStore(const Limits& limits, Journal* journal, TemplateMaker* templates, ClockFn clock);

  const SessionLimits& session_limits() const { return limits_.session; }

  // INVALID_ARGUMENT for a bad config, RESOURCE_EXHAUSTED naming the limit, the server's or the
  // owner's, FAILED_PRECONDITION when templates cannot be made here.
  absl::StatusOr<std::shared_ptr<SessionLedger>> Create(const Principal& owner,
                                                        SessionConfig config, absl::Time now);

  // Of all that follow: UNAVAILABLE, reason STORE_UNAVAILABLE, while the journal cannot be read or
  // written.

  // Loads the session from the journal where it is not in memory. NOT_FOUND naming the id;
  // DATA_LOSS.
  absl::StatusOr<std::shared_ptr<SessionLedger>> Find(const std::string& id);

  // At most `count` sessions of `owner` in order of id, the first one after `after`. Those not in
  // memory are without control mesh.
  absl::StatusOr<std::vector<std::shared_ptr<SessionLedger>>> List(const std::string& owner,
                                                                   const std::string& after,
                                                                   size_t count);

  // Opens a stream on the session as the journal has it. Errors as of Find.
  struct OpenedStream {
    std::shared_ptr<SessionLedger> ledger;
    SessionLedger::StreamOpening opening;
  };
  absl::StatusOr<OpenedStream> OpenStream(const std::string& id,
                                          const SessionLedger::EndStreamFn& end_stream);

  // Ends the session's stream; memory goes once the last lease does.
  absl::Status Delete(const std::string& id);

  // NOT_FOUND; UNAVAILABLE while another lease is held: callers take turns through the scheduler.
  absl::StatusOr<SessionLease> Lease(const std::string& id);

  // Takes sessions that nobody has used since `time` out of memory; a durable journal keeps them.
  void Unload(absl::Time time);
  // Ids of the sessions that have a stream.
  std::vector<std::string> Attached() const;
  // Deletes sessions that nobody has used since `time`, but none that has a stream here. Returns
  // how many.
  absl::StatusOr<int> Expire(absl::Time time);

 private:
  friend class SessionLease;
  using Entry = SessionLease::Entry;
  using EntryPtr = std::shared_ptr<Entry>;

  absl::Status CheckLimits(const SessionConfig& config) const;
  absl::StatusOr<std::shared_ptr<SessionLedger>> LoadLedger(const std::string& id,
                                                            bool with_template) const;
  absl::StatusOr<EntryPtr> FindEntry(const std::string& id);
  EntryPtr FindLoaded(const std::string& id);
  // The entry in memory, unless another server that shares the journal has moved it on: that one is
  // dropped, and null comes back. NOT_FOUND when it was deleted.
  absl::StatusOr<EntryPtr> FindCurrent(const std::string& id);
  void Drop(const SessionLedger& ledger);  // from memory
  // From the account; where it has no room, from models of sessions that are not leased.
  absl::Status Grow(int64_t bytes, MemoryReservation* memory);
  void Shed(int64_t bytes);
  absl::StatusOr<EntryPtr> MakeEntry(std::shared_ptr<SessionLedger> ledger);

  // Under create_mutex_.
  absl::Status CheckRoom(const Principal& owner) const;

  const Limits limits_;
  Journal* const journal_;
  TemplateMaker* const templates_;
  const ClockFn clock_;
  MemoryAccount unlimited_;
  MemoryAccount* const memory_;
  std::mutex create_mutex_;  // so that no two sessions take the last place
  mutable std::mutex mutex_;
  std::map<std::string, EntryPtr> entries_;  // in memory
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_SESSION_STORE_H_
