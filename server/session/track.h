// What a session's fits read of the frames before: where the surface was, and how well it lay.
#ifndef CAGEFIT_SERVER_SESSION_TRACK_H_
#define CAGEFIT_SERVER_SESSION_TRACK_H_

#include <vector>

#include "absl/status/statusor.h"
#include "core/mesh/control_mesh.h"
#include "core/metrics/verdict.h"
#include "server/session/session_ledger.h"
#include "server/session/stored_frame.h"

namespace cagefit::server {

// Follows from the answers alone. Empty until a frame is fitted.
class Track {
 public:
  // That of all answers in the ledger. Errors as of SessionLedger::StateOfFrame.
  static absl::StatusOr<Track> Replay(const SessionLedger& ledger);

  bool is_empty() const { return state_.vertices.cols() == 0; }  // no frame is fitted

  // Takes the next fitted frame in.
  void Advance(const StoredFrame& answer, SurfaceState state);

  // Where the next fit may begin, at least one; the template while nothing better is known.
  std::vector<Points3d> Starts(const ControlMesh& template_mesh) const;
  StartKind start_kind() const;

  // What the verdict on a fit has to know beside its distances.
  VerdictInput ExpectationOf(const FitSummary& fit) const;

  const GridPoints& q() const { return state_.q; }  // after the last fitted frame

 private:
  SurfaceState state_;
  Points3d before_{3, 0};                 // after the fitted frame before that
  Points3d last_good_{3, 0};              // after the last frame that was not LOST
  Points3d last_ok_{3, 0};                // after the last frame that was OK
  Verdict verdict_ = Verdict::kOk;        // of the last fitted frame
  std::vector<double> ok_rms_, ok_bare_;  // of the frames judged OK, sorted: RMS, bare share
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_TRACK_H_
