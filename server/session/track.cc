#include "server/session/track.h"

#include <algorithm>
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

// Samples that the target's points do not surround as densely as elsewhere.
double BareShare(const FitSummary& fit) {
  return static_cast<double>(fit.grown_samples + fit.far_samples) / std::max(1, fit.samples);
}

}  // namespace

absl::StatusOr<Track> Track::Replay(const SessionLedger& ledger) {
  Track track;
  SurfaceState state;
  const uint64_t end = ledger.Facts().next_sequence_number;
  for (uint64_t number = 0; number < end; ++number) {
    const std::shared_ptr<const StoredFrame> answer = ledger.Find(number);
    if (answer->outcome != Outcome::kFitted) continue;
    const EncodedDelta& delta = answer->delta;
    if (ledger.config().quantum == 0) {
      state.vertices = delta.positions.cast<double>();
    } else {
      ASSIGN_OR_RETURN(const VertexDelta decoded, Decode(delta, answer->control_vertices));
      RETURN_IF_ERROR(ApplyDelta(decoded, &state.q));
      state.vertices = Dequantize(state.q, delta.grid);
    }
    track.Advance(*answer, state);
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
