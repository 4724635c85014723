#include "server/transport/frame_log.h"

#include "server/transport/log_event.h"

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

void AddRejected(const StoredFrame& frame, LogEvent* event) {
  event->Add("code", absl::StatusCodeToString(frame.error.code()))
      .Add("error", frame.error.message())
      .AddNumber("queue_ms", frame.ms.queue)
      .AddNumber("decode_ms", frame.ms.decode);
}

void AddFitted(const StoredFrame& frame, LogEvent* event) {
  event->AddInteger("iterations", frame.fit.iterations)
      .AddNumber("rms", frame.distances.rms)
      .AddNumber("rms_percent", frame.rms_percent)
      .Add("verdict", Name(frame.verdict))
      .AddNumber("queue_ms", frame.ms.queue)
      .AddNumber("decode_ms", frame.ms.decode)
      .AddNumber("template_ms", frame.ms.template_making)
      .AddNumber("index_ms", frame.ms.index)
      .AddNumber("solve_ms", frame.ms.solve)
      .AddNumber("measure_ms", frame.ms.measure)
      .AddNumber("encode_ms", frame.ms.encode);
}

const char* OutcomeOf(const FrameAnswer& answer) {
  if (answer.repeated) return "repeated";
  switch (answer.frame->outcome) {
    case Outcome::kFitted:
      return "fitted";
    case Outcome::kRejected:
      return "rejected";
    case Outcome::kSkipped:
      break;
  }
  return "skipped";
}

}  // namespace

void LogFrame(spdlog::logger& log, const std::string& session_id, const std::string& trace_id,
              const FrameAnswer& answer) {
  const StoredFrame& frame = *answer.frame;
  const bool rejected = !answer.repeated && frame.outcome == Outcome::kRejected;
  const auto level = rejected ? spdlog::level::warn : spdlog::level::info;
  if (!log.should_log(level)) return;
  LogEvent event("frame");
  event.Add("session", session_id)
      .AddInteger("frame", frame.sequence_number)
      .Add("trace_id", trace_id)
      .Add("outcome", OutcomeOf(answer));
  if (!answer.repeated && frame.outcome != Outcome::kSkipped) {
    event.AddInteger("points", static_cast<uint64_t>(frame.points));
    rejected ? AddRejected(frame, &event) : AddFitted(frame, &event);
  }
  log.log(level, event.text());
}

}  // namespace cagefit::server
