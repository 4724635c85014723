// What a server counts of its own work. Parts of the server add to it; who asks (metrics_port)
// reads it. Nothing here is of one session.
#ifndef CAGEFIT_SERVER_SESSION_METRICS_H_
#define CAGEFIT_SERVER_SESSION_METRICS_H_

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

#include "absl/status/status.h"

namespace cagefit::server {

struct FrameAnswer;

// Thread-safe, without locks.
class Counter {
 public:
  void Add(uint64_t count = 1) { value_.fetch_add(count, std::memory_order_relaxed); }
  uint64_t value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<uint64_t> value_{0};
};

// How long something took, by powers of two. Thread-safe, without locks: a reading while others add
// may lack what was added last in one of its parts.
class LatencyHistogram {
 public:
  static constexpr int kBounds = 18;
  // Upper bounds, seconds, ascending: 0.25 ms to 33 s. Longer ones count beyond the last.
  static constexpr double Bound(int k) { return 0.25e-3 * static_cast<double>(1 << k); }

  void Observe(double seconds);

  std::array<uint64_t, kBounds + 1> Counts() const;  // of each step, the last one beyond all bounds
  double Seconds() const;                            // sum

 private:
  std::array<std::atomic<uint64_t>, kBounds + 1> counts_{};
  std::atomic<int64_t> nanoseconds_{0};
};

// Counts by name, for what is rare. Names come from this program's own text, never from a client;
// those beyond kMaxNames count as "OTHER". Thread-safe.
class NamedCounters {
 public:
  static constexpr size_t kMaxNames = 100;

  void Add(const std::string& name);
  std::map<std::string, uint64_t> Values() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, uint64_t> values_;
};

struct Metrics {
  Counter frames_fitted, frames_rejected, frames_skipped, frames_repeated;
  Counter verdict_ok, verdict_suspect, verdict_lost;
  NamedCounters rejects;  // failed calls and rejected frames, by ErrorDetail::reason

  // Of frames that were fitted, and the first two of rejected ones, too.
  LatencyHistogram queue, decode, template_making, index, solve, measure, encode;
  LatencyHistogram store_seconds;  // commits of answers to the session store

  // A frame that was answered.
  void CountFrame(const FrameAnswer& answer);
  // A call or frame that failed: by its reason, or its code where it has none.
  void CountReject(const absl::Status& status);
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_METRICS_H_
