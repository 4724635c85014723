#include "server/transport/call_record.h"

#include "server/session/error_detail.h"
#include "server/session/metrics.h"
#include "server/transport/log_event.h"
#include "server/transport/status_convert.h"
#include "server/transport/trace.h"

namespace cagefit::server {
namespace {

spdlog::level::level_enum LevelOf(const absl::Status& status, bool is_stream) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return is_stream ? spdlog::level::info : spdlog::level::debug;
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kDataLoss:
    case absl::StatusCode::kResourceExhausted:
      return spdlog::level::warn;
    default:
      return spdlog::level::info;
  }
}

}  // namespace

CallRecord::CallRecord(const ServiceState& state, grpc::CallbackServerContext* context,
                       const char* method)
    : state_(state),
      context_(context),
      method_(method),
      trace_id_(TraceIdOf(*context)),
      start_ms_(state.clock()) {}

grpc::Status CallRecord::End(const absl::Status& status) {
  if (!status.ok()) state_.metrics->CountReject(status);
  Log(status);
  return ToGrpc(status, context_);
}

void CallRecord::Log(const absl::Status& status) const {
  const auto level = LevelOf(status, !session_id_.empty());
  if (!state_.log->should_log(level)) return;
  LogEvent event("call");
  event.Add("method", method_);
  if (!session_id_.empty()) event.Add("session", session_id_);
  event.Add("code", absl::StatusCodeToString(status.code()));
  if (const auto detail = DetailOf(status)) event.Add("reason", detail->reason);
  if (!status.ok()) event.Add("message", status.message());
  event.AddNumber("ms", state_.clock() - start_ms_);
  event.Add("peer", context_->peer()).Add("trace_id", trace_id_);
  state_.log->log(level, event.text());
}

}  // namespace cagefit::server
