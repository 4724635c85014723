// One direction of a connection through a FaultProxy. Internal to it.
#ifndef CAGEFIT_TESTS_SUPPORT_FAULTY_PIPE_H_
#define CAGEFIT_TESTS_SUPPORT_FAULTY_PIPE_H_

#include <chrono>
#include <cstdint>
#include <deque>
#include <string>

#include "tests/support/fault_plan.h"

namespace cagefit::testing {

// Moves bytes between two non-blocking sockets, which it does not own.
class FaultyPipe {
 public:
  using Clock = std::chrono::steady_clock;

  enum class State {
    kOpen,
    kEnded,      // the sender has closed, and everything is passed on
    kTruncated,  // its fault was that
    kReset,      // a socket failed, or its fault was that
  };

  FaultyPipe(int from, int to, const FaultPlan& plan) : from_(from), to_(to), plan_(plan) {}

  int from() const { return from_; }
  int to() const { return to_; }
  // What poll has to wait for.
  bool wants_bytes() const;
  bool wants_room(Clock::time_point now) const;
  // When Step has something to do without either; max() when never.
  Clock::time_point NextTime(Clock::time_point now) const;

  // Reads and writes what goes without blocking.
  State Step(Clock::time_point now);

  bool fault_began() const { return fault_began_; }

 private:
  struct Block {
    std::string bytes;
    Clock::time_point due;
  };

  bool Read(Clock::time_point now);   // false when the sender's side failed
  bool Write(Clock::time_point now);  // likewise the receiver's
  // How many bytes may be passed on now.
  int64_t Allowed(Clock::time_point now) const;
  void BeginFault(Clock::time_point now);
  void Passed(int64_t bytes, Clock::time_point now);

  const int from_, to_;
  const FaultPlan plan_;
  std::deque<Block> blocks_;  // read and not passed on
  int64_t waiting_bytes_ = 0;
  int64_t passed_bytes_ = 0;
  bool ended_ = false, end_passed_ = false;
  bool fault_began_ = false;
  Clock::time_point fault_ends_ = Clock::time_point::max();  // of hold and half-open
  Clock::time_point next_tick_{};                            // of trickle
};

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_FAULTY_PIPE_H_
