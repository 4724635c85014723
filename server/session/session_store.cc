#include "server/session/session_store.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "core/base/status.h"
#include "server/session/digest.h"
#include "server/session/error_detail.h"
#include "server/session/session_memory.h"

namespace cagefit::server {

SessionLease::~SessionLease() {
  if (entry_ == nullptr) return;
  entry_->Settle();
  entry_->use.store(Use::kFree, std::memory_order_release);
}

absl::Status SessionLease::Reserve(Work work, int64_t points) {
  Entry& entry = *entry_;
  if (work == Work::kEvaluateLoss) entry.evaluates = true;
  entry.points = std::max(entry.points, points);
  return store_->Grow(entry.NeededBytes(entry.points) - entry.memory.bytes(), &entry.memory);
}

int64_t SessionLease::Entry::NeededBytes(int64_t points) const {
  const SessionLedger& ledger = *session.ledger();
  const SessionConfig& config = ledger.config();
  const SessionFacts facts = ledger.Facts();
  const bool has_template =
      facts.fitted_frames > 0 || (facts.control_vertices > 0 && !config.tolerance.has_value());
  const int32_t vertices =
      has_template ? facts.control_vertices : MostFirstVertices(config, ledger.limits(), points);
  int64_t bytes = IdleSessionBytes(config, vertices);
  if (!ledger.is_durable()) bytes += facts.stored_bytes;
  // The loss has terms of its own.
  if (points > 0) bytes += (evaluates ? 2 : 1) * ModelBytes(config, vertices, points);
  return bytes;
}

void SessionLease::Entry::Settle() {
  if (!session.has_model()) {
    points = 0;
    evaluates = false;
  }
  memory.ShrinkTo(NeededBytes(points));
  session.ledger()->SetMemoryBytes(memory.bytes());
}

SessionStore::SessionStore(const Limits& limits, Journal* journal, TemplateMaker* templates,
                           ClockFn clock)
    : limits_(limits),
      journal_(journal),
      templates_(templates),
      clock_(std::move(clock)),
      unlimited_("memory of sessions", std::numeric_limits<int64_t>::max()),
      memory_(limits.memory != nullptr ? limits.memory : &unlimited_) {}

absl::Status SessionStore::CheckLimits(const SessionConfig& config) const {
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
  return absl::OkStatus();
}

absl::Status SessionStore::CheckRoom(const Principal& owner) const {
  ASSIGN_OR_RETURN(const int64_t sessions, journal_->Count());
  if (sessions >= limits_.max_sessions) {
    return LimitExceeded("sessions", sessions + 1, limits_.max_sessions, absl::Seconds(30));
  }
  if (!owner.quotas.sessions.has_value()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const int64_t own, journal_->CountOf(owner.name));
  if (own < *owner.quotas.sessions) return absl::OkStatus();
  return LimitExceeded("sessions of " + owner.name, own + 1, *owner.quotas.sessions,
                       absl::Seconds(30));
}

absl::StatusOr<std::shared_ptr<SessionLedger>> SessionStore::Create(const Principal& owner,
                                                                    SessionConfig config,
                                                                    absl::Time now) {
  RETURN_IF_ERROR(config.Validate());
  RETURN_IF_ERROR(CheckLimits(config));
  if (!config.control_mesh.has_value()) RETURN_IF_ERROR(templates_->CheckAvailable());

  SessionRecord record;
  record.id = RandomId();
  record.owner = owner.name;
  record.created = now;
  if (config.control_mesh.has_value()) {
    record.head.control_vertices = config.control_mesh->vertex_count();
    record.head.triangles = config.control_mesh->topology().triangle_count();
  }
  record.config = std::move(config);
  std::lock_guard<std::mutex> create(create_mutex_);
  RETURN_IF_ERROR(CheckRoom(owner));
  auto ledger = std::make_shared<SessionLedger>(record, std::nullopt, limits_.session, journal_);
  ASSIGN_OR_RETURN(EntryPtr entry, MakeEntry(ledger));
  RETURN_IF_ERROR(journal_->Create(record));
  entry->last_used = now;
  std::lock_guard<std::mutex> lock(mutex_);
  entries_.emplace(ledger->id(), std::move(entry));
  return ledger;
}

absl::StatusOr<std::shared_ptr<SessionLedger>> SessionStore::LoadLedger(const std::string& id,
                                                                        bool with_template) const {
  ASSIGN_OR_RETURN(SessionRecord record, journal_->Load(id));
  std::optional<ControlMesh> template_mesh;
  if (with_template) {
    ASSIGN_OR_RETURN(template_mesh, journal_->LoadTemplate(id));
  }
  if (record.head.fitted_frames == 0) {
    record.config.control_mesh = std::exchange(template_mesh, std::nullopt);
  }
  return std::make_shared<SessionLedger>(std::move(record), std::move(template_mesh),
                                         limits_.session, journal_);
}

SessionStore::EntryPtr SessionStore::FindLoaded(const std::string& id) {
  std::lock_guard<std::mutex> lock(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return nullptr;
  found->second->last_used = absl::Now();
  return found->second;
}

absl::StatusOr<SessionStore::EntryPtr> SessionStore::FindCurrent(const std::string& id) {
  EntryPtr loaded = FindLoaded(id);
  if (loaded == nullptr || !journal_->is_durable()) return loaded;
  const SessionLedger& ledger = *loaded->session.ledger();
  const SessionFacts facts = ledger.Facts();
  // Of a session that has its stream here, the next write will tell.
  if (facts.stream_attached) return loaded;
  const auto stored = journal_->Load(id);
  // What is in memory is better than nothing while the journal is away.
  if (absl::IsUnavailable(stored.status())) return loaded;
  if (stored.ok() && stored->head.epoch == facts.epoch &&
      stored->head.next_sequence_number == facts.next_sequence_number) {
    return loaded;
  }
  Drop(ledger);
  RETURN_IF_ERROR(stored.status());
  return nullptr;
}

absl::StatusOr<SessionStore::EntryPtr> SessionStore::FindEntry(const std::string& id) {
  ASSIGN_OR_RETURN(EntryPtr loaded, FindCurrent(id));
  if (loaded != nullptr) return loaded;
  ASSIGN_OR_RETURN(auto ledger, LoadLedger(id, /*with_template=*/true));
  ASSIGN_OR_RETURN(EntryPtr entry, MakeEntry(std::move(ledger)));
  entry->last_used = absl::Now();
  std::lock_guard<std::mutex> lock(mutex_);
  return entries_.emplace(id, std::move(entry)).first->second;  // or who was faster
}

absl::StatusOr<std::shared_ptr<SessionLedger>> SessionStore::Find(const std::string& id) {
  ASSIGN_OR_RETURN(const EntryPtr entry, FindEntry(id));
  return entry->session.ledger();
}

absl::StatusOr<std::vector<std::shared_ptr<SessionLedger>>> SessionStore::List(
    const std::string& owner, const std::string& after, size_t count) {
  ASSIGN_OR_RETURN(const std::vector<std::string> ids, journal_->Ids(owner, after, count));
  std::vector<std::shared_ptr<SessionLedger>> page;
  for (const std::string& id : ids) {
    const auto loaded = FindCurrent(id);
    if (loaded.ok() && *loaded != nullptr) {
      page.push_back((*loaded)->session.ledger());
      continue;
    }
    auto ledger = LoadLedger(id, /*with_template=*/false);
    if (absl::IsNotFound(ledger.status())) continue;  // deleted meanwhile
    RETURN_IF_ERROR(ledger.status());
    page.push_back(*std::move(ledger));
  }
  return page;
}

absl::StatusOr<SessionStore::OpenedStream> SessionStore::OpenStream(
    const std::string& id, const SessionLedger::EndStreamFn& end_stream) {
  for (;;) {
    ASSIGN_OR_RETURN(std::shared_ptr<SessionLedger> ledger, Find(id));
    ASSIGN_OR_RETURN(const auto opening, ledger->OpenStream(end_stream));
    if (opening.has_value()) return OpenedStream{std::move(ledger), *opening};
    Drop(*ledger);
  }
}

void SessionStore::Drop(const SessionLedger& ledger) {
  std::lock_guard<std::mutex> lock(mutex_);
  const auto found = entries_.find(ledger.id());
  if (found != entries_.end() && found->second->session.ledger().get() == &ledger) {
    entries_.erase(found);
  }
}

absl::Status SessionStore::Delete(const std::string& id) {
  RETURN_IF_ERROR(journal_->Delete(id));
  if (const EntryPtr loaded = FindLoaded(id)) {
    Drop(*loaded->session.ledger());
    loaded->session.ledger()->MarkDeleted();
  }
  return absl::OkStatus();
}

absl::StatusOr<SessionLease> SessionStore::Lease(const std::string& id) {
  ASSIGN_OR_RETURN(EntryPtr entry, FindEntry(id));
  using Use = SessionLease::Use;
  for (Use use = Use::kFree; !entry->use.compare_exchange_strong(use, Use::kLeased);
       use = Use::kFree) {
    if (use == Use::kLeased) {
      return absl::UnavailableError(absl::StrCat("session ", id, " is in use"));
    }
    std::this_thread::yield();  // its model is just being dropped
  }
  return SessionLease(this, std::move(entry));
}

absl::StatusOr<SessionStore::EntryPtr> SessionStore::MakeEntry(
    std::shared_ptr<SessionLedger> ledger) {
  auto entry =
      std::make_shared<Entry>(std::move(ledger), templates_, clock_, MemoryReservation(memory_));
  RETURN_IF_ERROR(Grow(entry->NeededBytes(0), &entry->memory));
  entry->Settle();
  return entry;
}

absl::Status SessionStore::Grow(int64_t bytes, MemoryReservation* memory) {
  if (bytes <= 0) return absl::OkStatus();
  const absl::Status taken = memory->Grow(bytes);
  if (taken.ok()) return taken;
  Shed(bytes);
  return memory->Grow(bytes);
}

void SessionStore::Shed(int64_t bytes) {
  using Use = SessionLease::Use;
  std::vector<std::pair<absl::Time, EntryPtr>> by_use;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    for (const auto& [id, entry] : entries_) by_use.emplace_back(entry->last_used, entry);
  }
  std::sort(by_use.begin(), by_use.end());
  for (const auto& [time, entry] : by_use) {
    Use use = Use::kFree;
    if (!entry->use.compare_exchange_strong(use, Use::kShedding)) continue;
    const int64_t before = entry->memory.bytes();
    entry->session.DropModel();
    entry->Settle();
    bytes -= before - entry->memory.bytes();
    entry->use.store(Use::kFree, std::memory_order_release);
    if (bytes <= 0) return;
  }
}

void SessionStore::Unload(absl::Time time) {
  if (!journal_->is_durable()) return;
  std::vector<EntryPtr> unloaded;  // destroyed outside the lock
  std::lock_guard<std::mutex> lock(mutex_);
  for (auto e = entries_.begin(); e != entries_.end();) {
    // Whoever has a ledger may open a stream on it, so nobody must have this one.
    const bool is_idle = e->second.use_count() == 1 &&
                         e->second->session.ledger().use_count() == 1 &&
                         e->second->last_used < time;
    if (is_idle) unloaded.push_back(std::move(e->second));
    e = is_idle ? entries_.erase(e) : std::next(e);
  }
}

std::vector<std::string> SessionStore::Attached() const {
  std::vector<std::string> ids;
  std::lock_guard<std::mutex> lock(mutex_);
  for (const auto& [id, entry] : entries_) {
    if (entry->session.ledger()->Facts().stream_attached) ids.push_back(id);
  }
  return ids;
}

absl::StatusOr<int> SessionStore::Expire(absl::Time time) {
  constexpr size_t kMostAtOnce = 100;
  const std::vector<std::string> attached = Attached();
  RETURN_IF_ERROR(journal_->Touch(attached, absl::Now()));
  ASSIGN_OR_RETURN(const std::vector<std::string> unused, journal_->UnusedSince(time, kMostAtOnce));
  int expired = 0;
  for (const std::string& id : unused) {
    const absl::Status deleted = Delete(id);
    if (absl::IsNotFound(deleted)) continue;
    RETURN_IF_ERROR(deleted);
    ++expired;
  }
  return expired;
}

}  // namespace cagefit::server
