#include "server/session/metrics.h"

#include <cmath>
#include <optional>

#include "server/session/error_detail.h"
#include "server/session/session.h"

namespace cagefit::server {

void LatencyHistogram::Observe(double seconds) {
  int step = 0;
  while (step < kBounds && !(seconds <= Bound(step))) ++step;
  counts_[step].fetch_add(1, std::memory_order_relaxed);
  nanoseconds_.fetch_add(std::llround(seconds * 1e9), std::memory_order_relaxed);
}

std::array<uint64_t, LatencyHistogram::kBounds + 1> LatencyHistogram::Counts() const {
  std::array<uint64_t, kBounds + 1> counts;
  for (int k = 0; k <= kBounds; ++k) counts[k] = counts_[k].load(std::memory_order_relaxed);
  return counts;
}

double LatencyHistogram::Seconds() const {
  return 1e-9 * static_cast<double>(nanoseconds_.load(std::memory_order_relaxed));
}

void NamedCounters::Add(const std::string& name) {
  std::lock_guard<std::mutex> lock(mutex_);
  const bool full = values_.size() >= kMaxNames && values_.count(name) == 0;
  ++values_[full ? "OTHER" : name];
}

std::map<std::string, uint64_t> NamedCounters::Values() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return values_;
}

void Metrics::CountFrame(const FrameAnswer& answer) {
  const StoredFrame& frame = *answer.frame;
  if (answer.repeated) return frames_repeated.Add();
  if (frame.outcome == Outcome::kSkipped) return frames_skipped.Add();
  const auto observe = [](LatencyHistogram* histogram, double ms) { histogram->Observe(ms / 1e3); };
  observe(&queue, frame.ms.queue);
  observe(&decode, frame.ms.decode);
  if (frame.outcome == Outcome::kRejected) {
    frames_rejected.Add();
    return CountReject(frame.error);
  }
  frames_fitted.Add();
  switch (frame.verdict) {
    case Verdict::kOk:
      verdict_ok.Add();
      break;
    case Verdict::kSuspect:
      verdict_suspect.Add();
      break;
    case Verdict::kLost:
      verdict_lost.Add();
      break;
  }
  if (frame.ms.template_making > 0) observe(&template_making, frame.ms.template_making);
  observe(&index, frame.ms.index);
  observe(&solve, frame.ms.solve);
  observe(&measure, frame.ms.measure);
  observe(&encode, frame.ms.encode);
}

void Metrics::CountReject(const absl::Status& status) {
  const std::optional<ErrorDetail> detail = DetailOf(status);
  rejects.Add(detail.has_value() ? detail->reason : absl::StatusCodeToString(status.code()));
}

}  // namespace cagefit::server
