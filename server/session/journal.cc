#include "server/session/journal.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "server/session/error_detail.h"

namespace cagefit::server {

SessionHead After(SessionHead head, const StoredFrame& frame, const ControlMesh* made_template) {
  head.stored_bytes += frame.StoredBytes();
  switch (frame.outcome) {
    case Outcome::kFitted:
      ++head.fitted_frames;
      head.last_fitted = frame.sequence_number;
      break;
    case Outcome::kRejected:
      ++head.rejected_frames;
      break;
    case Outcome::kSkipped:
      ++head.skipped_frames;
      break;
  }
  ++head.next_sequence_number;
  if (made_template != nullptr) {
    head.control_vertices = made_template->vertex_count();
    head.triangles = made_template->topology().triangle_count();
  }
  return head;
}

FrameOutline OutlineOf(const StoredFrame& frame) {
  FrameOutline outline;
  outline.sequence_number = frame.sequence_number;
  outline.outcome = frame.outcome;
  outline.verdict = frame.verdict;
  outline.key = frame.delta.key;
  outline.rms = frame.distances.rms;
  outline.bare_share = BareShare(frame.fit);
  return outline;
}

absl::Status NoSession(const std::string& id) {
  return WithDetail(absl::NotFoundError(absl::StrCat("session_id is \"", id, "\"; there is none")),
                    {"NO_SESSION", "session_id", id, ""});
}

absl::Status SessionDeleted(const std::string& id) {
  return WithDetail(absl::AbortedError(absl::StrCat("session ", id, " was deleted")),
                    {"SESSION_DELETED", "session_id", id, ""});
}

absl::Status EpochSuperseded(uint64_t epoch, uint64_t current) {
  return WithDetail(
      absl::AbortedError(absl::StrCat("epoch ", epoch, " was superseded by epoch ", current,
                                      ": another stream was opened on this session")),
      {"EPOCH_SUPERSEDED", "epoch", absl::StrCat(epoch), absl::StrCat(current)});
}

}  // namespace cagefit::server
