// The seam behind which sessions outlive the fit in progress, and, where the journal is on a disk,
// the process: what each was made from, who may write to it, and every answer.
#ifndef CAGEFIT_SERVER_SESSION_JOURNAL_H_
#define CAGEFIT_SERVER_SESSION_JOURNAL_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/mesh/control_mesh.h"
#include "server/session/session_config.h"
#include "server/session/stored_frame.h"

namespace cagefit::server {

// What changes of a session with its streams and frames.
struct SessionHead {
  uint64_t epoch = 0;
  uint64_t next_sequence_number = 0;
  uint64_t fitted_frames = 0;
  uint64_t rejected_frames = 0;
  uint64_t skipped_frames = 0;
  std::optional<uint64_t> last_fitted;  // sequence number
  int64_t stored_bytes = 0;             // of all answers
  int32_t control_vertices = 0;         // 0 until the template is made
  int32_t triangles = 0;
};

struct SessionRecord {
  std::string id;
  std::string owner;  // name of the principal that made it
  absl::Time created;
  SessionConfig config;
  SessionHead head;
};

// What later fits read of an answer, but for its delta.
struct FrameOutline {
  uint64_t sequence_number = 0;
  Outcome outcome = Outcome::kRejected;
  Verdict verdict = Verdict::kOk;
  bool key = false;
  double rms = 0;
  double bare_share = 0;
};

// `head` with one more answer, and the template that it made, if it did.
SessionHead After(SessionHead head, const StoredFrame& frame, const ControlMesh* made_template);
FrameOutline OutlineOf(const StoredFrame& frame);

// Thread-safe. What a call wrote is durable when it returns. Errors of all: NOT_FOUND for a session
// that is not there; UNAVAILABLE, reason STORE_UNAVAILABLE, while the journal cannot be read or
// written: nothing is changed then, as far as is known; DATA_LOSS for a record that is broken.
// Those that write for a stream: ABORTED, reason EPOCH_SUPERSEDED or SESSION_DELETED, when its
// epoch has passed.
class Journal {
 public:
  virtual ~Journal() = default;

  virtual absl::Status Create(const SessionRecord& record) = 0;
  // Without the control mesh of its config: LoadTemplate has it.
  virtual absl::StatusOr<SessionRecord> Load(const std::string& id) = 0;
  // The control mesh that came with the config, until a frame has made or refined another.
  virtual absl::StatusOr<std::optional<ControlMesh>> LoadTemplate(const std::string& id) = 0;
  // At most `count` ids of the owner's sessions in their order, the first one after `after`.
  virtual absl::StatusOr<std::vector<std::string>> Ids(const std::string& owner,
                                                       const std::string& after, size_t count) = 0;
  virtual absl::StatusOr<int64_t> Count() = 0;  // of sessions
  virtual absl::StatusOr<int64_t> CountOf(const std::string& owner) = 0;
  virtual absl::Status Delete(const std::string& id) = 0;

  // A new stream may write from now on, and no older one.
  virtual absl::StatusOr<SessionHead> RaiseEpoch(const std::string& id) = 0;
  // A fit of the next frame begins; returns how often one has, this one included, without an answer
  // or an Abandon. So a frame that takes the process down with it is known.
  virtual absl::StatusOr<int> Begin(const std::string& id, uint64_t epoch) = 0;
  // A fit of that frame ended in good order without an answer, whoever may write now.
  virtual absl::Status Abandon(const std::string& id, uint64_t sequence_number) = 0;
  // Stores the answer to the next frame, and the template that it made, if it did.
  virtual absl::Status Append(const std::string& id, uint64_t epoch,
                              std::shared_ptr<const StoredFrame> frame,
                              const ControlMesh* made_template) = 0;

  // Null when that frame is not answered.
  virtual absl::StatusOr<std::shared_ptr<const StoredFrame>> Read(const std::string& id,
                                                                  uint64_t sequence_number) = 0;
  // Of all answers, in order.
  virtual absl::StatusOr<std::vector<FrameOutline>> Outlines(const std::string& id) = 0;

  // Sessions in use at `now`; those that are gone are passed over. Create, RaiseEpoch and Append
  // are uses as well.
  virtual absl::Status Touch(const std::vector<std::string>& ids, absl::Time now) = 0;
  // At most `count` sessions last used before `time`.
  virtual absl::StatusOr<std::vector<std::string>> UnusedSince(absl::Time time, size_t count) = 0;

  // OK when the journal can be written; tries to get there when it could not.
  virtual absl::Status Probe() = 0;
  // Sessions survive this process.
  virtual bool is_durable() const = 0;
};

// Errors that all journals have in common.
absl::Status NoSession(const std::string& id);
absl::Status SessionDeleted(const std::string& id);
absl::Status EpochSuperseded(uint64_t epoch, uint64_t current);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_JOURNAL_H_
