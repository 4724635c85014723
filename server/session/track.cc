#include "server/session/track.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/base/status.h"
#include "core/fit/extrapolation.h"

namespace cagefit::server {
namespace {

// What bent goes on bending, a little slower. Where it does not, the fitter takes the other start.
constexpr double kMomentum = 0.8;

// Of a sorted list that is not empty.
double Median(const std::vector<double>& sorted) { return sorted[sorted.size() / 2]; }

void Insert(double value, std::vector<double>* sorted) {
  sorted->insert(std::upper_bound(sorted->begin(), sorted->end(), value), value);
}

}  // namespace

absl::StatusOr<Track> Track::Replay(const SessionLedger& ledger) {
  ASSIGN_OR_RETURN(const std::vector<FrameOutline> frames, ledger.Outlines());
  Track track;
  std::optional<uint64_t> last, before, last_good, last_ok;
  for (const FrameOutline& frame : frames) {
    if (frame.outcome != Outcome::kFitted) continue;
    const bool is_lost = frame.verdict == Verdict::kLost;
    before = is_lost || track.verdict_ == Verdict::kLost ? std::nullopt : last;
    last = frame.sequence_number;
    track.verdict_ = frame.verdict;
    if (!is_lost) last_good = last;
    if (frame.verdict != Verdict::kOk) continue;
    last_ok = last;
    track.ok_rms_.push_back(frame.rms);
    track.ok_bare_.push_back(frame.bare_share);
  }
  std::sort(track.ok_rms_.begin(), track.ok_rms_.end());
  std::sort(track.ok_bare_.begin(), track.ok_bare_.end());
  if (last.has_value()) {
    ASSIGN_OR_RETURN(track.state_, ledger.StateOfFrame(*last));
  }
  for (const auto& [number, vertices] :
       {std::pair(before, &track.before_), std::pair(last_good, &track.last_good_),
        std::pair(last_ok, &track.last_ok_)}) {
    if (!number.has_value()) continue;
    ASSIGN_OR_RETURN(SurfaceState state, ledger.StateOfFrame(*number));
    *vertices = std::move(state.vertices);
  }
  return track;
}

void Track::Advance(const StoredFrame& answer, SurfaceState state) {
  // A LOST surface says nothing about the motion, neither as the last frame nor as the one before.
  const bool is_lost = answer.verdict == Verdict::kLost;
  const bool has_motion = !is_empty() && !is_lost && verdict_ != Verdict::kLost;
  before_ = has_motion ? std::move(state_.vertices) : Points3d(3, 0);
  state_ = std::move(state);
  verdict_ = answer.verdict;
  if (!is_lost) last_good_ = state_.vertices;
  if (verdict_ != Verdict::kOk) return;
  last_ok_ = state_.vertices;
  Insert(answer.distances.rms, &ok_rms_);
  Insert(BareShare(answer.fit), &ok_bare_);
}

std::vector<Points3d> Track::Starts(const ControlMesh& template_mesh) const {
  std::vector<Points3d> starts;
  if (verdict_ == Verdict::kLost) {
    if (last_good_.cols() > 0) starts.push_back(last_good_);
  } else if (!is_empty()) {
    starts.push_back(state_.vertices);
    if (before_.cols() > 0) {
      starts.push_back(ExtrapolateMotion(before_, state_.vertices, kMomentum));
    }
  }
  // A frame that lacked a part may have bent the surface out of shape.
  if (verdict_ != Verdict::kOk && last_ok_.cols() > 0) starts.push_back(last_ok_);
  if (starts.empty()) starts.push_back(template_mesh.vertices());
  return starts;
}

StartKind Track::start_kind() const {
  return last_good_.cols() > 0 ? StartKind::kEarlierFit : StartKind::kTemplate;
}

VerdictInput Track::ExpectationOf(const FitSummary& fit) const {
  VerdictInput known;
  known.bare_share = BareShare(fit);
  if (ok_rms_.empty()) return known;
  known.median_rms = Median(ok_rms_);
  known.median_bare_share = Median(ok_bare_);
  return known;
}

}  // namespace cagefit::server
