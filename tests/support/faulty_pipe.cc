#include "tests/support/faulty_pipe.h"

#include <errno.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <limits>

namespace cagefit::testing {
namespace {

// A receiver that does not read is felt by the sender.
constexpr int64_t kMostWaitingBytes = 64 << 10;

bool MustWait() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

bool FaultyPipe::wants_bytes() const {
  const bool dropped = fault_began_ && plan_.fault == Fault::kHalfOpen;
  return !ended_ && (dropped || waiting_bytes_ < kMostWaitingBytes);
}

bool FaultyPipe::wants_room(Clock::time_point now) const {
  return !blocks_.empty() && Allowed(now) > 0;
}

FaultyPipe::Clock::time_point FaultyPipe::NextTime(Clock::time_point now) const {
  Clock::time_point next = Clock::time_point::max();
  if (fault_began_ && (plan_.fault == Fault::kHold || plan_.fault == Fault::kHalfOpen) &&
      fault_ends_ > now) {
    next = fault_ends_;
  }
  if (blocks_.empty()) return next;
  if (fault_began_ && plan_.fault == Fault::kTrickle) next = std::min(next, next_tick_);
  if (blocks_.front().due > now) next = std::min(next, blocks_.front().due);
  return next;
}

int64_t FaultyPipe::Allowed(Clock::time_point now) const {
  constexpr int64_t kAll = std::numeric_limits<int64_t>::max();
  if (plan_.fault == Fault::kNone) return kAll;
  if (!fault_began_) return plan_.after_bytes - passed_bytes_;
  switch (plan_.fault) {
    case Fault::kHold:
      return now < fault_ends_ ? 0 : kAll;
    case Fault::kDelay:
      return blocks_.front().due <= now ? static_cast<int64_t>(blocks_.front().bytes.size()) : 0;
    case Fault::kTrickle:
      return now < next_tick_ ? 0 : plan_.trickle_bytes;
    default:
      return 0;
  }
}

void FaultyPipe::BeginFault(Clock::time_point now) {
  fault_began_ = true;
  next_tick_ = now + plan_.time;
  if (plan_.fault == Fault::kHold || plan_.time.count() > 0) fault_ends_ = now + plan_.time;
  // What has been read already is late, too.
  if (plan_.fault == Fault::kDelay) {
    for (Block& block : blocks_) block.due = now + plan_.time;
  }
}

bool FaultyPipe::Read(Clock::time_point now) {
  char bytes[16 << 10];
  while (wants_bytes()) {
    const ssize_t count = recv(from_, bytes, sizeof(bytes), MSG_DONTWAIT);
    if (count < 0) return MustWait();
    if (count == 0) {
      ended_ = true;
      return true;
    }
    const bool late = fault_began_ && plan_.fault == Fault::kDelay;
    blocks_.push_back({std::string(bytes, count), late ? now + plan_.time : now});
    waiting_bytes_ += count;
    if (fault_began_ && plan_.fault == Fault::kHalfOpen) {
      blocks_.clear();
      waiting_bytes_ = 0;
    }
  }
  return true;
}

void FaultyPipe::Passed(int64_t bytes, Clock::time_point now) {
  passed_bytes_ += bytes;
  waiting_bytes_ -= bytes;
  blocks_.front().bytes.erase(0, bytes);
  if (blocks_.front().bytes.empty()) blocks_.pop_front();
  if (fault_began_) next_tick_ = now + plan_.time;
}

bool FaultyPipe::Write(Clock::time_point now) {
  while (wants_room(now)) {
    const std::string& bytes = blocks_.front().bytes;
    const int64_t size = std::min<int64_t>(Allowed(now), static_cast<int64_t>(bytes.size()));
    const ssize_t count = send(to_, bytes.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count < 0) return MustWait();
    Passed(count, now);
  }
  return true;
}

FaultyPipe::State FaultyPipe::Step(Clock::time_point now) {
  if (!Read(now) || !Write(now)) return State::kReset;
  const bool at_fault = plan_.fault != Fault::kNone && !fault_began_ && !blocks_.empty() &&
                        passed_bytes_ == plan_.after_bytes;
  if (at_fault) {
    BeginFault(now);
    if (plan_.fault == Fault::kReset) return State::kReset;
    if (plan_.fault == Fault::kTruncate) return State::kTruncated;
    if (plan_.fault == Fault::kHalfOpen) {
      blocks_.clear();
      waiting_bytes_ = 0;
    }
    if (!Read(now) || !Write(now)) return State::kReset;
  }
  if (fault_began_ && plan_.fault == Fault::kHalfOpen && now >= fault_ends_) return State::kReset;
  if (ended_ && blocks_.empty() && !end_passed_) {
    // A half-open direction does not tell of the end, either.
    end_passed_ = true;
    if (!(fault_began_ && plan_.fault == Fault::kHalfOpen)) shutdown(to_, SHUT_WR);
  }
  return end_passed_ ? State::kEnded : State::kOpen;
}

}  // namespace cagefit::testing
