// A session at work: frames go in one by one, answers come out and are stored.
#ifndef CAGEFIT_SERVER_SESSION_SESSION_H_
#define CAGEFIT_SERVER_SESSION_SESSION_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "core/base/cancel.h"
#include "server/session/frame.h"
#include "server/session/session_ledger.h"
#include "server/session/stored_frame.h"
#include "server/session/surface_model.h"
#include "server/session/template_maker.h"
#include "server/session/track.h"

namespace cagefit::server {

struct FrameAnswer {
  std::shared_ptr<const StoredFrame> frame;
  bool repeated = false;  // stored earlier; nothing was fitted
};

// The energy at some control vertices.
struct Loss {
  Energies energies;
  Points3d gradient;  // 3 x n, 1 / user unit
};

// One user at a time: through a SessionLease. A session that begins with a ledger of fitted frames
// goes on behind them, with the same bits as the one that fitted them.
//
// A fit reads the session's config, its template, the control vertices after the two fitted frames
// before and after the last frames that were OK and not LOST (as the client has them), the verdicts
// and RMS of the frames before, and the frame's bytes; nothing else, so the same frames give the
// same bits.
class Session {
 public:
  // `templates` must outlive the session.
  Session(std::shared_ptr<SessionLedger> ledger, TemplateMaker* templates, ClockFn clock);

  const std::shared_ptr<SessionLedger>& ledger() const { return ledger_; }

  // When a fit lets others go first.
  struct Turns {
    std::function<bool()> is_over;   // null: never
    std::function<void()> give_way;  // returns when it is the fit's turn again
  };

  // Answers a decoded frame that came by the stream of `epoch`.
  //
  // The next number is fitted, or rejected for good with INVALID_ARGUMENT or INTERNAL in the
  // answer, and stored. One whose fit was begun kMostBegun times, and each time took the process
  // down with it, is rejected as well: INTERNAL, reason POISON_FRAME. A fit that waits for its turn
  // is not suspected, and one that was suspected before runs to its end. An earlier number gets its
  // stored answer. An error leaves the session as it was, stores nothing and is the end of the
  // stream: DATA_LOSS for a ledger that does not replay, ALREADY_EXISTS for an earlier number with
  // other bytes, OUT_OF_RANGE naming the expected number for a later one, ABORTED when the epoch
  // has passed, UNAVAILABLE when the journal cannot be read or written, CANCELLED,
  // RESOURCE_EXHAUSTED, FAILED_PRECONDITION.
  absl::StatusOr<FrameAnswer> Answer(Frame frame, uint64_t epoch, const CancelFn& cancelled,
                                     const Turns& turns = {});
  static constexpr int kMostBegun = 3;

  // Answers a frame that is not to be fitted, likewise. The surface stays as it was.
  absl::StatusOr<FrameAnswer> Skip(const SkippedFrame& frame, uint64_t epoch);

  // What a fit builds of the template and keeps: most of a session's memory. The next fit builds it
  // again where it was dropped, and comes to the same bits.
  bool has_model() const { return model_.has_value(); }
  void DropModel();

  // The loss of `vertices` (3 x n, user units) against a decoded frame, or the one fitted last
  // where `frame` is null, as Fitter::Evaluate has it from where the next fit would start. No
  // answer depends on it. Before a frame is fitted, `frame` is taken for the first.
  // INVALID_ARGUMENT naming field and value, or what is wrong with the frame; FAILED_PRECONDITION
  // without a template, or without a frame; CANCELLED, RESOURCE_EXHAUSTED.
  absl::StatusOr<Loss> EvaluateLoss(const Points3d& vertices, const Frame* frame,
                                    const CancelFn& cancelled);

 private:
  // What a fit leaves behind; moved into the session once the answer is stored.
  struct Step {
    std::optional<SurfaceModel> first_model;  // of the first fitted frame
    SurfaceState state;
  };

  // Replays the ledger's frames, where this session has seen none of its fitted ones. DATA_LOSS
  // when they do not replay.
  absl::Status Restore();
  absl::Status ReplayTrack();

  absl::StatusOr<FrameAnswer> Repeat(uint64_t sequence_number, const Digest& digest);
  // The answer to the next frame, fitted or rejected; its fit has begun `begun` times.
  absl::StatusOr<std::shared_ptr<StoredFrame>> AnswerNext(const Frame& frame, int begun,
                                                          const CancelFn& cancelled, Step* step);
  absl::Status Fit(const Frame& frame, const CancelFn& cancelled, StoredFrame* answer, Step* step);
  // What the frame holds for the image loss.
  FrameSource SourceOf(const Frame& frame) const;
  absl::StatusOr<SurfaceModel> MakeModel(const Frame& frame, const CancelFn& cancelled,
                                         StoredFrame* answer);
  // The template of tolerance mode. From its vertices, the fit that follows is the last one of
  // FitToTolerance over again, so what is reported holds for what the client gets.
  absl::StatusOr<ControlMesh> RefineTemplate(const ControlMesh& start, const Frame& frame,
                                             const CancelFn& cancelled, StoredFrame* answer) const;
  absl::Status EncodeState(const SurfaceModel& model, const Points3d& fitted, StoredFrame* answer,
                           Step* step) const;
  absl::Status Store(uint64_t epoch, const std::shared_ptr<StoredFrame>& answer, Step step);
  // What EvaluateLoss asks before a frame is fitted.
  absl::StatusOr<Loss> FirstLoss(const Points3d& vertices, const Frame& frame,
                                 const CancelFn& cancelled) const;

  std::shared_ptr<SessionLedger> ledger_;
  TemplateMaker* templates_;
  ClockFn clock_;

  std::optional<SurfaceModel> model_;  // empty until a frame is fitted
  bool frame_in_memory_ = false;       // the model's fitter still has the frame fitted last
  Track track_;                        // of the fitted frames

  uint64_t stream_epoch_ = 0;
  bool key_needed_ = true;  // the client may not know q_
  uint32_t fitted_since_key_ = 0;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_SESSION_H_
