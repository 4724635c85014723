#include "server/session/fair_queue.h"

#include <algorithm>

namespace cagefit::server {
namespace {

// Idle keys of a priority that are remembered; those that owe least are forgotten first.
constexpr size_t kMostIdle = 4096;

Priority Other(Priority priority) {
  return priority == Priority::kLive ? Priority::kBatch : Priority::kLive;
}

}  // namespace

FairQueue::FairQueue() {
  GroupOf(Priority::kLive).share = 1 - kBatchShare;
  GroupOf(Priority::kBatch).share = kBatchShare;
}

void FairQueue::Add(const std::string& key, Priority priority) {
  Group& group = GroupOf(priority);
  const auto found = members_.find(key);
  double clock = group.now;
  if (found != members_.end()) {
    // A key that was idle may have changed its priority: its debt was to the others.
    if (found->second.priority == priority) clock = std::max(clock, found->second.clock);
    GroupOf(found->second.priority).idle.erase(found->second.place);
  }
  // A group that comes back brings along no more than a key does.
  if (!group.is_active()) group.clock = std::max(group.clock, now_);
  Member& member = members_[key];
  member.priority = priority;
  member.clock = std::min(clock, group.now + kMostDebtMs);
  member.place = {member.clock + member.task_ms, ++arrivals_, key};
  group.waiting.insert(member.place);
}

bool FairQueue::empty() const {
  return std::all_of(groups_.begin(), groups_.end(),
                     [](const Group& group) { return group.waiting.empty(); });
}

std::string FairQueue::Take() {
  Group& live = GroupOf(Priority::kLive);
  Group& batch = GroupOf(Priority::kBatch);
  const bool is_batch =
      live.waiting.empty() || (!batch.waiting.empty() && batch.clock < live.clock);
  Group& group = is_batch ? batch : live;
  const auto first = group.waiting.begin();
  std::string key = std::get<std::string>(*first);
  group.waiting.erase(first);
  ++group.taken;
  GoOn(key);
  return key;
}

void FairQueue::GoOn(const std::string& key) {
  const Member& member = members_.at(key);
  Group& group = GroupOf(member.priority);
  now_ = std::max(now_, group.clock);
  group.now = std::max(group.now, member.clock);
}

bool FairQueue::IsOvertaken(const std::string& key) const {
  const Member& member = members_.at(key);
  const Group& own = GroupOf(member.priority);
  const Group& other = GroupOf(Other(member.priority));
  if (!other.waiting.empty() && other.clock < own.clock) return true;
  return !own.waiting.empty() && std::get<double>(*own.waiting.begin()) < member.clock;
}

void FairQueue::Charge(const std::string& key, double ms) {
  Member& member = members_.at(key);
  member.clock += ms;
  Group& group = GroupOf(member.priority);
  group.clock += ms / group.share;
  const Group& other = GroupOf(Other(member.priority));
  if (other.is_active()) group.clock = std::min(group.clock, other.clock + kMostGroupDebtMs);
}

void FairQueue::Expect(const std::string& key, double ms) { members_.at(key).task_ms = ms; }

void FairQueue::Release(const std::string& key) {
  Member& member = members_.at(key);
  Group& group = GroupOf(member.priority);
  --group.taken;
  member.place = {member.clock, ++arrivals_, key};
  group.idle.insert(member.place);
  if (group.idle.size() <= kMostIdle) return;
  members_.erase(std::get<std::string>(*group.idle.begin()));
  group.idle.erase(group.idle.begin());
}

}  // namespace cagefit::server
