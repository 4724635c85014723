#include "server/store/memory_journal.h"

#include <algorithm>
#include <utility>

#include "absl/time/clock.h"
#include "core/base/status.h"

namespace cagefit::server {

absl::StatusOr<MemoryJournal::Entry*> MemoryJournal::Find(const std::string& id) {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return NoSession(id);
  return &found->second;
}

absl::StatusOr<MemoryJournal::Entry*> MemoryJournal::FindForStream(const std::string& id,
                                                                   uint64_t epoch) {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return SessionDeleted(id);
  const uint64_t current = found->second.record.head.epoch;
  if (current != epoch) return EpochSuperseded(epoch, current);
  return &found->second;
}

absl::Status MemoryJournal::Create(const SessionRecord& record) {
  Entry entry;
  entry.record = record;
  entry.template_mesh = std::exchange(entry.record.config.control_mesh, std::nullopt);
  entry.last_used = record.created;
  std::lock_guard<std::mutex> lock(mutex_);
  entries_.emplace(record.id, std::move(entry));
  return absl::OkStatus();
}

absl::StatusOr<SessionRecord> MemoryJournal::Load(const std::string& id) {
  std::lock_guard<std::mutex> lock(mutex_);
  ASSIGN_OR_RETURN(const Entry* entry, Find(id));
  return entry->record;
}

absl::StatusOr<std::optional<ControlMesh>> MemoryJournal::LoadTemplate(const std::string& id) {
  std::lock_guard<std::mutex> lock(mutex_);
  ASSIGN_OR_RETURN(const Entry* entry, Find(id));
  return entry->template_mesh;
}

absl::StatusOr<std::vector<std::string>> MemoryJournal::Ids(const std::string& owner,
                                                            const std::string& after,
                                                            size_t count) {
  std::vector<std::string> ids;
  std::lock_guard<std::mutex> lock(mutex_);
  for (auto e = entries_.upper_bound(after); e != entries_.end() && ids.size() < count; ++e) {
    if (e->second.record.owner == owner) ids.push_back(e->first);
  }
  return ids;
}

absl::StatusOr<int64_t> MemoryJournal::Count() {
  std::lock_guard<std::mutex> lock(mutex_);
  return static_cast<int64_t>(entries_.size());
}

absl::StatusOr<int64_t> MemoryJournal::CountOf(const std::string& owner) {
  std::lock_guard<std::mutex> lock(mutex_);
  return std::count_if(entries_.begin(), entries_.end(),
                       [&owner](const auto& entry) { return entry.second.record.owner == owner; });
}

absl::Status MemoryJournal::Delete(const std::string& id) {
  std::map<std::string, Entry>::node_type deleted;  // destroyed outside the lock
  std::lock_guard<std::mutex> lock(mutex_);
  deleted = entries_.extract(id);
  return deleted.empty() ? NoSession(id) : absl::OkStatus();
}

absl::StatusOr<SessionHead> MemoryJournal::RaiseEpoch(const std::string& id) {
  std::lock_guard<std::mutex> lock(mutex_);
  ASSIGN_OR_RETURN(Entry * entry, Find(id));
  ++entry->record.head.epoch;
  entry->last_used = absl::Now();
  return entry->record.head;
}

absl::StatusOr<int> MemoryJournal::Begin(const std::string& id, uint64_t epoch) {
  std::lock_guard<std::mutex> lock(mutex_);
  ASSIGN_OR_RETURN(Entry * entry, FindForStream(id, epoch));
  return ++entry->begun;
}

absl::Status MemoryJournal::Abandon(const std::string& id, uint64_t sequence_number) {
  std::lock_guard<std::mutex> lock(mutex_);
  ASSIGN_OR_RETURN(Entry * entry, Find(id));
  if (entry->record.head.next_sequence_number != sequence_number) return absl::OkStatus();
  entry->begun = std::max(0, entry->begun - 1);
  return absl::OkStatus();
}

absl::Status MemoryJournal::Append(const std::string& id, uint64_t epoch,
                                   std::shared_ptr<const StoredFrame> frame,
                                   const ControlMesh* made_template) {
  std::lock_guard<std::mutex> lock(mutex_);
  ASSIGN_OR_RETURN(Entry * entry, FindForStream(id, epoch));
  entry->record.head = After(entry->record.head, *frame, made_template);
  if (made_template != nullptr) entry->template_mesh = *made_template;
  entry->frames.push_back(std::move(frame));
  entry->begun = 0;
  entry->last_used = absl::Now();
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const StoredFrame>> MemoryJournal::Read(const std::string& id,
                                                                       uint64_t sequence_number) {
  std::lock_guard<std::mutex> lock(mutex_);
  ASSIGN_OR_RETURN(const Entry* entry, Find(id));
  return sequence_number < entry->frames.size() ? entry->frames[sequence_number] : nullptr;
}

absl::StatusOr<std::vector<FrameOutline>> MemoryJournal::Outlines(const std::string& id) {
  std::vector<FrameOutline> outlines;
  std::lock_guard<std::mutex> lock(mutex_);
  ASSIGN_OR_RETURN(const Entry* entry, Find(id));
  for (const auto& frame : entry->frames) outlines.push_back(OutlineOf(*frame));
  return outlines;
}

absl::Status MemoryJournal::Touch(const std::vector<std::string>& ids, absl::Time now) {
  std::lock_guard<std::mutex> lock(mutex_);
  for (const std::string& id : ids) {
    const auto found = entries_.find(id);
    if (found != entries_.end()) found->second.last_used = now;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> MemoryJournal::UnusedSince(absl::Time time, size_t count) {
  std::vector<std::string> ids;
  std::lock_guard<std::mutex> lock(mutex_);
  for (auto e = entries_.begin(); e != entries_.end() && ids.size() < count; ++e) {
    if (e->second.last_used < time) ids.push_back(e->first);
  }
  return ids;
}

}  // namespace cagefit::server
