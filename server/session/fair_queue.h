// Who is served next, fair in time: of the keys that wait, the one that would have used least after
// its next task, if that takes as long as its last one did (weighted fair queueing).
//
// Every key has a clock that advances by the time that it used. One that comes back after a pause
// does not bring along what it left unused: its clock starts where the queue's is, the latest clock
// of a key that was served. One that has used more than its share keeps its debt until the others
// have caught up. The two priorities have clocks, too, which
// advance by the time that their keys used over their share of it: while live work waits, batch
// work gets kBatchShare, and all that live work leaves.
#ifndef CAGEFIT_SERVER_SESSION_FAIR_QUEUE_H_
#define CAGEFIT_SERVER_SESSION_FAIR_QUEUE_H_

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>

#include "server/session/priority.h"

namespace cagefit::server {

// Not thread-safe. A key is idle, or waits, or is taken.
class FairQueue {
 public:
  static constexpr double kBatchShare = 0.05;
  // More than this a key never owes: work that cannot be interrupted does not lock its key out for
  // as long as it took.
  static constexpr double kMostDebtMs = 10'000;
  // Likewise a priority, by its clock: batch work waits for 19 s of live work at most.
  static constexpr double kMostGroupDebtMs = 20'000;

  FairQueue();

  // `key`, which is idle, waits from now on.
  void Add(const std::string& key, Priority priority);
  bool empty() const;  // no key waits

  // The key whose turn it is; then it is taken. Requires that one waits.
  std::string Take();
  // Whether a key that waits would come to its end before `key`, which is taken, as it stands now.
  bool IsOvertaken(const std::string& key) const;
  // `key`, which is taken, has used `ms`.
  void Charge(const std::string& key, double ms);
  // A task of `key`, which is taken, took `ms` in all.
  void Expect(const std::string& key, double ms);
  // `key`, which is taken, keeps its turn.
  void GoOn(const std::string& key);
  // `key`, which is taken, is idle from now on.
  void Release(const std::string& key);

  size_t remembered() const { return members_.size(); }

 private:
  using Place = std::tuple<double, uint64_t, std::string>;  // clock after a task, arrival, key

  struct Member {
    Priority priority = Priority::kLive;
    double clock = 0;
    double task_ms = 0;  // its last one
    Place place;         // in `waiting` or `idle`
  };
  // All keys of one priority.
  struct Group {
    double share = 1;  // of the time
    double clock = 0;  // its own
    double now = 0;    // clock of the member that was served last
    int taken = 0;     // members
    bool is_active() const { return taken > 0 || !waiting.empty(); }
    std::set<Place> waiting;
    std::set<Place> idle;  // by clock alone
  };

  Group& GroupOf(Priority priority) { return groups_[static_cast<size_t>(priority)]; }
  const Group& GroupOf(Priority priority) const { return groups_[static_cast<size_t>(priority)]; }

  std::array<Group, 2> groups_;
  double now_ = 0;  // clock of the group that was served last
  uint64_t arrivals_ = 0;
  std::map<std::string, Member> members_;  // those that wait or are taken, and the latest idle ones
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_FAIR_QUEUE_H_
