#include "server/session/session_ledger.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

absl::Status NoTemplateYet(const std::string& id) {
  return WithDetail(
      absl::FailedPreconditionError(absl::StrCat(
          "session ", id,
          " has no control mesh yet: it is made from the first frame; stream one through "
          "FitFrames")),
      {"NO_TEMPLATE_YET", "session_id", id, ""});
}

absl::Status NotFitted(uint64_t sequence_number, absl::string_view why) {
  return WithDetail(absl::NotFoundError(absl::StrCat("frame ", sequence_number, " ", why)),
                    {"FRAME_NOT_FITTED", "sequence_number", absl::StrCat(sequence_number), ""});
}

}  // namespace

SessionLedger::SessionLedger(SessionRecord record, std::optional<ControlMesh> made_template,
                             const SessionLimits& limits, Journal* journal)
    : record_(std::move(record)),
      limits_(limits),
      journal_(journal),
      facts_{record_.head, /*stream_attached=*/false},
      made_template_(std::move(made_template)) {}

void SessionLedger::SetMemoryBytes(int64_t bytes) {
  std::lock_guard<std::mutex> lock(mutex_);
  facts_.memory_bytes = bytes;
}

SessionFacts SessionLedger::Facts() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return facts_;
}

absl::StatusOr<std::optional<SessionLedger::StreamOpening>> SessionLedger::OpenStream(
    EndStreamFn end_stream) {
  std::unique_lock<std::mutex> write(write_mutex_);
  ASSIGN_OR_RETURN(const SessionHead head, journal_->RaiseEpoch(id()));
  EndStreamFn end_older;
  uint64_t older_epoch = 0;
  bool is_current = false;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    older_epoch = facts_.epoch;
    is_current = !deleted_ && head.epoch == facts_.epoch + 1 &&
                 head.next_sequence_number == facts_.next_sequence_number;
    end_older = std::exchange(end_stream_, is_current ? std::move(end_stream) : nullptr);
    facts_.epoch = head.epoch;
    facts_.stream_attached = is_current;
  }
  write.unlock();
  if (end_older) end_older(EpochSuperseded(older_epoch, head.epoch));
  if (!is_current) return std::optional<StreamOpening>();
  return std::optional<StreamOpening>({head.epoch, head.next_sequence_number});
}

void SessionLedger::CloseStream(uint64_t epoch) {
  EndStreamFn released;  // destroyed outside the lock: it may hold the last reference to its stream
  std::lock_guard<std::mutex> lock(mutex_);
  if (epoch != facts_.epoch) return;
  released = std::exchange(end_stream_, nullptr);
  facts_.stream_attached = false;
}

void SessionLedger::MarkDeleted() {
  EndStreamFn end_stream;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    deleted_ = true;
    end_stream = std::exchange(end_stream_, nullptr);
    facts_.stream_attached = false;
  }
  if (end_stream) end_stream(SessionDeleted(id()));
}

absl::Status SessionLedger::CheckEpochLocked(uint64_t epoch) const {
  if (deleted_) return SessionDeleted(id());
  if (epoch != facts_.epoch) return EpochSuperseded(epoch, facts_.epoch);
  return absl::OkStatus();
}

absl::Status SessionLedger::CheckEpoch(uint64_t epoch) const {
  std::lock_guard<std::mutex> lock(mutex_);
  return CheckEpochLocked(epoch);
}

absl::Status SessionLedger::CheckRoom() const {
  std::lock_guard<std::mutex> lock(mutex_);
  const int64_t frames = static_cast<int64_t>(facts_.next_sequence_number);
  if (frames >= limits_.max_frames) {
    return LimitExceeded("frames of a session", frames + 1, limits_.max_frames);
  }
  if (facts_.stored_bytes >= limits_.max_history_bytes) {
    return LimitExceeded("stored bytes of a session", facts_.stored_bytes,
                         limits_.max_history_bytes);
  }
  return absl::OkStatus();
}

absl::StatusOr<int> SessionLedger::Begin(uint64_t epoch) {
  std::lock_guard<std::mutex> write(write_mutex_);
  RETURN_IF_ERROR(CheckEpoch(epoch));
  return journal_->Begin(id(), epoch);
}

absl::Status SessionLedger::Abandon(uint64_t sequence_number) {
  std::lock_guard<std::mutex> write(write_mutex_);
  return journal_->Abandon(id(), sequence_number);
}

absl::Status SessionLedger::Append(uint64_t epoch, std::shared_ptr<const StoredFrame> frame,
                                   std::optional<ControlMesh> made_template) {
  std::lock_guard<std::mutex> write(write_mutex_);
  RETURN_IF_ERROR(CheckEpoch(epoch));
  const ControlMesh* made = made_template.has_value() ? &*made_template : nullptr;
  RETURN_IF_ERROR(journal_->Append(id(), epoch, frame, made));
  std::lock_guard<std::mutex> lock(mutex_);
  static_cast<SessionHead&>(facts_) = After(facts_, *frame, made);
  if (made != nullptr) made_template_ = std::move(made_template);
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const StoredFrame>> SessionLedger::Find(
    uint64_t sequence_number) const {
  return journal_->Read(id(), sequence_number);
}

absl::StatusOr<std::vector<FrameOutline>> SessionLedger::Outlines() const {
  return journal_->Outlines(id());
}

absl::StatusOr<ControlMesh> SessionLedger::TemplateMesh() const {
  if (std::lock_guard<std::mutex> lock(mutex_); made_template_.has_value()) return *made_template_;
  if (config().control_mesh.has_value()) return *config().control_mesh;
  return NoTemplateYet(id());
}

absl::StatusOr<ControlMesh> SessionLedger::FinalTemplate() const {
  const bool is_to_be_refined = config().tolerance.has_value() && Facts().fitted_frames == 0;
  if (is_to_be_refined) return NoTemplateYet(id());
  return TemplateMesh();
}

absl::StatusOr<ControlMesh> SessionLedger::LatestMesh() const {
  const std::optional<uint64_t> last = Facts().last_fitted;
  return last.has_value() ? MeshOfFrame(*last) : TemplateMesh();
}

absl::StatusOr<ControlMesh> SessionLedger::MeshOfFrame(uint64_t sequence_number) const {
  ASSIGN_OR_RETURN(const SurfaceState state, StateOfFrame(sequence_number));
  ASSIGN_OR_RETURN(const ControlMesh mesh, TemplateMesh());
  return mesh.WithVertices(state.vertices);
}

absl::StatusOr<SurfaceState> SessionLedger::StateOfFrame(uint64_t sequence_number) const {
  ASSIGN_OR_RETURN(const std::shared_ptr<const StoredFrame> frame, Find(sequence_number));
  if (frame == nullptr) return NotFitted(sequence_number, "has not been answered");
  if (frame->outcome == Outcome::kRejected) return NotFitted(sequence_number, "was rejected");
  if (frame->outcome == Outcome::kSkipped) return NotFitted(sequence_number, "was skipped");
  SurfaceState state;
  if (config().quantum == 0) {
    state.vertices = frame->delta.positions.cast<double>();
  } else {
    ASSIGN_OR_RETURN(state.q, GridPointsOfFrame(*frame));
    state.vertices = Dequantize(state.q, frame->delta.grid);
  }
  return state;
}

absl::StatusOr<GridPoints> SessionLedger::GridPointsOfFrame(const StoredFrame& frame) const {
  // Back to its key frame, at most key_interval fitted frames, and forth again.
  std::vector<VertexDelta> replay;
  ASSIGN_OR_RETURN(VertexDelta delta, Decode(frame.delta, frame.control_vertices));
  replay.push_back(std::move(delta));
  for (uint64_t k = frame.sequence_number; k-- > 0 && !replay.back().key;) {
    ASSIGN_OR_RETURN(const std::shared_ptr<const StoredFrame> earlier, Find(k));
    if (earlier == nullptr || earlier->outcome != Outcome::kFitted) continue;
    ASSIGN_OR_RETURN(delta, Decode(earlier->delta, earlier->control_vertices));
    replay.push_back(std::move(delta));
  }
  GridPoints q;
  for (auto step = replay.rbegin(); step != replay.rend(); ++step) {
    RETURN_IF_ERROR(ApplyDelta(*step, &q));
  }
  return q;
}

}  // namespace cagefit::server
