// What is known of a session beside the fit in progress: who may write to it, and every answer so
// far. The journal has it all; the ledger keeps what is small.
//
// Numbers and epoch change under one lock, so the next number that a stream is told when it opens
// stays true until that stream itself, or a newer one, moves on.
#ifndef CAGEFIT_SERVER_SESSION_SESSION_LEDGER_H_
#define CAGEFIT_SERVER_SESSION_SESSION_LEDGER_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/session/journal.h"
#include "server/session/session_config.h"
#include "server/session/stored_frame.h"

namespace cagefit::server {

struct SessionFacts : SessionHead {
  bool stream_attached = false;
  int64_t memory_bytes = 0;  // that the session holds
};

// Thread-safe. Config, id and creation time never change.
class SessionLedger {
 public:
  // Called at most once, without any lock held, on the thread that ended the stream's right to
  // write.
  using EndStreamFn = std::function<void(const absl::Status&)>;

  struct StreamOpening {
    uint64_t epoch = 0;
    uint64_t next_sequence_number = 0;
  };

  // `record` is in `journal`, which must outlive the ledger. `made_template`: the template that a
  // frame has made, if one has.
  SessionLedger(SessionRecord record, std::optional<ControlMesh> made_template,
                const SessionLimits& limits, Journal* journal);

  const std::string& id() const { return record_.id; }
  const std::string& owner() const { return record_.owner; }
  const SessionConfig& config() const { return record_.config; }
  const SessionLimits& limits() const { return limits_; }
  absl::Time created() const { return record_.created; }
  bool is_durable() const { return journal_->is_durable(); }
  SessionFacts Facts() const;
  void SetMemoryBytes(int64_t bytes);

  // Raises the epoch and ends an older stream: ABORTED, reason EPOCH_SUPERSEDED. Nothing when the
  // journal has moved on without this ledger, by another process or in a write that seemed to fail:
  // then the session has to be loaded anew.
  absl::StatusOr<std::optional<StreamOpening>> OpenStream(EndStreamFn end_stream);
  // The stream of that epoch writes no more. Nothing happens when a newer one has taken over.
  void CloseStream(uint64_t epoch);
  // The session was deleted from the journal. Ends the stream: ABORTED, reason SESSION_DELETED.
  // Later writes fail.
  void MarkDeleted();

  // OK while the stream of that epoch may write.
  absl::Status CheckEpoch(uint64_t epoch) const;
  // RESOURCE_EXHAUSTED when the session may not store another answer.
  absl::Status CheckRoom() const;

  // As Journal's, for the next frame.
  absl::StatusOr<int> Begin(uint64_t epoch);
  absl::Status Abandon(uint64_t sequence_number);
  // Stores the answer to the next frame, and the template that it made, if it did. ABORTED when
  // the epoch has passed, UNAVAILABLE when the journal cannot be written.
  absl::Status Append(uint64_t epoch, std::shared_ptr<const StoredFrame> frame,
                      std::optional<ControlMesh> made_template);

  // The stored answer, or null when there is none yet.
  absl::StatusOr<std::shared_ptr<const StoredFrame>> Find(uint64_t sequence_number) const;
  absl::StatusOr<std::vector<FrameOutline>> Outlines() const;

  // FAILED_PRECONDITION until the template is made.
  absl::StatusOr<ControlMesh> TemplateMesh() const;
  // The template that fits use: as TemplateMesh, but in tolerance mode FAILED_PRECONDITION also
  // while a given control mesh is to be refined by the first frame.
  absl::StatusOr<ControlMesh> FinalTemplate() const;
  // The latest fit, or the template when nothing is fitted yet.
  absl::StatusOr<ControlMesh> LatestMesh() const;
  // The fit of one frame. NOT_FOUND when there is none.
  absl::StatusOr<ControlMesh> MeshOfFrame(uint64_t sequence_number) const;
  // The control vertices of one fitted frame, as the client has them; `q` has them on the grid
  // where the session has one. DATA_LOSS when the stored deltas do not replay.
  absl::StatusOr<SurfaceState> StateOfFrame(uint64_t sequence_number) const;

 private:
  absl::Status CheckEpochLocked(uint64_t epoch) const;
  // Replayed from the key frame before it.
  absl::StatusOr<GridPoints> GridPointsOfFrame(const StoredFrame& frame) const;

  const SessionRecord record_;  // its head is that of the beginning
  const SessionLimits limits_;
  Journal* const journal_;

  std::mutex write_mutex_;  // held while the journal is written, before mutex_
  mutable std::mutex mutex_;
  bool deleted_ = false;
  SessionFacts facts_;
  EndStreamFn end_stream_;
  std::optional<ControlMesh> made_template_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_SESSION_LEDGER_H_
