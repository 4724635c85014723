#include "server/session/session_ledger.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

absl::Status Superseded(uint64_t epoch, uint64_t current) {
  return WithDetail(
      absl::AbortedError(absl::StrCat("epoch ", epoch, " was superseded by epoch ", current,
                                      ": another stream was opened on this session")),
      {"EPOCH_SUPERSEDED", "epoch", absl::StrCat(epoch), absl::StrCat(current)});
}

absl::Status Deleted(const std::string& id) {
  return WithDetail(absl::AbortedError(absl::StrCat("session ", id, " was deleted")),
                    {"SESSION_DELETED", "session_id", id, ""});
}

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

SessionLedger::SessionLedger(std::string id, SessionConfig config, const SessionLimits& limits,
                             absl::Time created)
    : id_(std::move(id)),
      config_(std::move(config)),
      limits_(limits),
      created_(created),
      template_mesh_(config_.control_mesh) {
  if (template_mesh_.has_value()) {
    facts_.control_vertices = template_mesh_->vertex_count();
    facts_.triangles = template_mesh_->topology().triangle_count();
  }
}

SessionFacts SessionLedger::Facts() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return facts_;
}

absl::StatusOr<SessionLedger::StreamOpening> SessionLedger::OpenStream(EndStreamFn end_stream) {
  EndStreamFn end_older;
  StreamOpening opening;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (deleted_) return absl::NotFoundError(absl::StrCat("no session ", id_));
    end_older = std::exchange(end_stream_, std::move(end_stream));
    opening.epoch = ++facts_.epoch;
    opening.next_sequence_number = facts_.next_sequence_number;
    facts_.stream_attached = true;
  }
  if (end_older) end_older(Superseded(opening.epoch - 1, opening.epoch));
  return opening;
}

void SessionLedger::CloseStream(uint64_t epoch) {
  EndStreamFn released;  // destroyed outside the lock: it may hold the last reference to its stream
  std::lock_guard<std::mutex> lock(mutex_);
  if (epoch != facts_.epoch) return;
  released = std::exchange(end_stream_, nullptr);
  facts_.stream_attached = false;
}

void SessionLedger::Delete() {
  EndStreamFn end_stream;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    deleted_ = true;
    end_stream = std::exchange(end_stream_, nullptr);
    facts_.stream_attached = false;
  }
  if (end_stream) end_stream(Deleted(id_));
}

absl::Status SessionLedger::CheckEpochLocked(uint64_t epoch) const {
  if (deleted_) return Deleted(id_);
  if (epoch != facts_.epoch) return Superseded(epoch, facts_.epoch);
  return absl::OkStatus();
}

absl::Status SessionLedger::CheckEpoch(uint64_t epoch) const {
  std::lock_guard<std::mutex> lock(mutex_);
  return CheckEpochLocked(epoch);
}

absl::Status SessionLedger::CheckRoom() const {
  std::lock_guard<std::mutex> lock(mutex_);
  const int64_t frames = static_cast<int64_t>(frames_.size());
  if (frames >= limits_.max_frames) {
    return LimitExceeded("frames of a session", frames + 1, limits_.max_frames);
  }
  if (stored_bytes_ >= limits_.max_history_bytes) {
    return LimitExceeded("stored bytes of a session", stored_bytes_, limits_.max_history_bytes);
  }
  return absl::OkStatus();
}

absl::Status SessionLedger::Append(uint64_t epoch, std::shared_ptr<const StoredFrame> frame,
                                   std::optional<ControlMesh> surface,
                                   std::optional<ControlMesh> template_mesh) {
  std::lock_guard<std::mutex> lock(mutex_);
  RETURN_IF_ERROR(CheckEpochLocked(epoch));
  stored_bytes_ += frame->StoredBytes();
  ++(frame->outcome == Outcome::kFitted ? facts_.fitted_frames : facts_.rejected_frames);
  ++facts_.next_sequence_number;
  frames_.push_back(std::move(frame));
  if (surface.has_value()) latest_mesh_ = std::move(surface);
  if (template_mesh.has_value()) {
    facts_.control_vertices = template_mesh->vertex_count();
    facts_.triangles = template_mesh->topology().triangle_count();
    template_mesh_ = std::move(template_mesh);
  }
  return absl::OkStatus();
}

std::shared_ptr<const StoredFrame> SessionLedger::Find(uint64_t sequence_number) const {
  std::lock_guard<std::mutex> lock(mutex_);
  return sequence_number < frames_.size() ? frames_[sequence_number] : nullptr;
}

absl::StatusOr<ControlMesh> SessionLedger::TemplateMesh() const {
  std::lock_guard<std::mutex> lock(mutex_);
  if (template_mesh_.has_value()) return *template_mesh_;
  return NoTemplateYet(id_);
}

absl::StatusOr<ControlMesh> SessionLedger::FinalTemplate() const {
  const bool is_to_be_refined = config_.tolerance.has_value() && Facts().fitted_frames == 0;
  if (is_to_be_refined) return NoTemplateYet(id_);
  return TemplateMesh();
}

absl::StatusOr<ControlMesh> SessionLedger::LatestMesh() const {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (latest_mesh_.has_value()) return *latest_mesh_;
  }
  return TemplateMesh();
}

absl::StatusOr<ControlMesh> SessionLedger::MeshOfFrame(uint64_t sequence_number) const {
  const std::shared_ptr<const StoredFrame> frame = Find(sequence_number);
  if (frame == nullptr) return NotFitted(sequence_number, "has not been answered");
  if (frame->outcome != Outcome::kFitted) return NotFitted(sequence_number, "was rejected");
  ASSIGN_OR_RETURN(const ControlMesh mesh, TemplateMesh());
  if (config_.quantum == 0) return mesh.WithVertices(frame->delta.positions.cast<double>());
  ASSIGN_OR_RETURN(const GridPoints q, GridPointsOfFrame(sequence_number));
  return mesh.WithVertices(Dequantize(q, frame->delta.grid));
}

absl::StatusOr<GridPoints> SessionLedger::GridPointsOfFrame(uint64_t sequence_number) const {
  // From the frame back to its key frame; at most key_interval fitted frames.
  std::vector<std::shared_ptr<const StoredFrame>> replay;
  int64_t vertices = 0;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    for (uint64_t k = sequence_number + 1; k-- > 0;) {
      if (frames_[k]->outcome != Outcome::kFitted) continue;
      replay.push_back(frames_[k]);
      if (frames_[k]->delta.key) break;
    }
    vertices = facts_.control_vertices;
  }
  GridPoints q;
  for (auto frame = replay.rbegin(); frame != replay.rend(); ++frame) {
    ASSIGN_OR_RETURN(const VertexDelta delta, Decode((*frame)->delta, vertices));
    RETURN_IF_ERROR(ApplyDelta(delta, &q));
  }
  return q;
}

}  // namespace cagefit::server
