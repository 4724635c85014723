// What is known of a session beside the fit in progress: who may write to it, and every answer so
// far.
//
// Numbers and epoch change under one lock, so the next number that a stream is told when it opens
// stays true until that stream itself, or a newer one, moves on.
#ifndef CAGEFIT_SERVER_SESSION_SESSION_LEDGER_H_
#define CAGEFIT_SERVER_SESSION_SESSION_LEDGER_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "server/session/session_config.h"
#include "server/session/stored_frame.h"

namespace cagefit::server {

struct SessionFacts {
  uint64_t epoch = 0;
  uint64_t next_sequence_number = 0;
  uint64_t fitted_frames = 0;
  uint64_t rejected_frames = 0;
  int32_t control_vertices = 0;  // 0 until the template is made
  int32_t triangles = 0;
  bool stream_attached = false;
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

  SessionLedger(std::string id, SessionConfig config, const SessionLimits& limits,
                absl::Time created);

  const std::string& id() const { return id_; }
  const SessionConfig& config() const { return config_; }
  const SessionLimits& limits() const { return limits_; }
  absl::Time created() const { return created_; }
  SessionFacts Facts() const;

  // Raises the epoch and ends an older stream: ABORTED, reason EPOCH_SUPERSEDED. NOT_FOUND once
  // the session is deleted.
  absl::StatusOr<StreamOpening> OpenStream(EndStreamFn end_stream);
  // The stream of that epoch writes no more. Nothing happens when a newer one has taken over.
  void CloseStream(uint64_t epoch);
  // Ends the stream: ABORTED, reason SESSION_DELETED. Later writes fail.
  void Delete();

  // OK while the stream of that epoch may write.
  absl::Status CheckEpoch(uint64_t epoch) const;
  // RESOURCE_EXHAUSTED when the session may not store another answer.
  absl::Status CheckRoom() const;

  // Stores the answer to frame next_sequence_number. `surface` is the mesh after a fitted frame and
  // `template_mesh` the template that it made, if it did. ABORTED when the epoch has passed.
  absl::Status Append(uint64_t epoch, std::shared_ptr<const StoredFrame> frame,
                      std::optional<ControlMesh> surface, std::optional<ControlMesh> template_mesh);

  // The stored answer, or null when there is none yet.
  std::shared_ptr<const StoredFrame> Find(uint64_t sequence_number) const;

  // FAILED_PRECONDITION until the template is made.
  absl::StatusOr<ControlMesh> TemplateMesh() const;
  // The template that fits use: as TemplateMesh, but in tolerance mode FAILED_PRECONDITION also
  // while a given control mesh is to be refined by the first frame.
  absl::StatusOr<ControlMesh> FinalTemplate() const;
  // The latest fit, or the template when nothing is fitted yet.
  absl::StatusOr<ControlMesh> LatestMesh() const;
  // The fit of one frame. NOT_FOUND when there is none.
  absl::StatusOr<ControlMesh> MeshOfFrame(uint64_t sequence_number) const;
  // The integers of one fitted frame, replayed from the key frame before it.
  absl::StatusOr<GridPoints> GridPointsOfFrame(uint64_t sequence_number) const;

 private:
  absl::Status CheckEpochLocked(uint64_t epoch) const;

  const std::string id_;
  const SessionConfig config_;
  const SessionLimits limits_;
  const absl::Time created_;

  mutable std::mutex mutex_;
  bool deleted_ = false;
  SessionFacts facts_;
  EndStreamFn end_stream_;
  std::deque<std::shared_ptr<const StoredFrame>> frames_;  // by sequence number
  int64_t stored_bytes_ = 0;
  std::optional<ControlMesh> template_mesh_;
  std::optional<ControlMesh> latest_mesh_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_SESSION_LEDGER_H_
