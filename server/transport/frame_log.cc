#include "server/transport/frame_log.h"

#include "absl/strings/escaping.h"

namespace cagefit::server {
namespace {

const char* Name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk:
      return "ok";
    case Verdict::kSuspect:
      return "suspect";
    case Verdict::kLost:
      return "lost";
  }
  return "unknown";
}

// Messages may carry what a client sent: no line breaks get into the log.
std::string Quoted(absl::string_view text) { return '"' + absl::CEscape(text) + '"'; }

}  // namespace

void LogFrame(spdlog::logger& log, const std::string& session_id, const FrameAnswer& answer) {
  const StoredFrame& frame = *answer.frame;
  if (answer.repeated) {
    log.info("frame session={} frame={} outcome=repeated", session_id, frame.sequence_number);
    return;
  }
  if (frame.outcome == Outcome::kSkipped) {
    log.info("frame session={} frame={} outcome=skipped", session_id, frame.sequence_number);
    return;
  }
  if (frame.outcome == Outcome::kRejected) {
    log.warn(
        "frame session={} frame={} points={} outcome=rejected code={} error={} queue_ms={:.2f} "
        "decode_ms={:.2f}",
        session_id, frame.sequence_number, frame.points, frame.error.raw_code(),
        Quoted(frame.error.message()), frame.ms.queue, frame.ms.decode);
    return;
  }
  log.info(
      "frame session={} frame={} points={} outcome=fitted iterations={} rms={:.6g} "
      "rms_percent={:.4f} verdict={} queue_ms={:.2f} decode_ms={:.2f} template_ms={:.2f} "
      "index_ms={:.2f} solve_ms={:.2f} measure_ms={:.2f} encode_ms={:.2f}",
      session_id, frame.sequence_number, frame.points, frame.fit.iterations, frame.distances.rms,
      frame.rms_percent, Name(frame.verdict), frame.ms.queue, frame.ms.decode,
      frame.ms.template_making, frame.ms.index, frame.ms.solve, frame.ms.measure, frame.ms.encode);
}

void LogStreamEnd(spdlog::logger& log, const std::string& session_id, uint64_t epoch,
                  const absl::Status& status) {
  log.info("stream session={} epoch={} code={} message={}", session_id, epoch, status.raw_code(),
           Quoted(status.message()));
}

}  // namespace cagefit::server
