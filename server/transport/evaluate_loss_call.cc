#include "server/transport/evaluate_loss_call.h"

#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"
#include "server/session/session_memory.h"
#include "server/transport/frame_assembler.h"
#include "server/transport/message_parts.h"
#include "server/transport/status_convert.h"

namespace cagefit::server {
namespace {

// A frame and the control vertices of the largest session.
int64_t MaxRequestBytes(const SessionLimits& limits) {
  constexpr int64_t kRest = 1 << 16;
  return limits.max_frame_bytes + int64_t{24} * limits.max_control_vertices + kRest;
}

}  // namespace

EvaluateLossCall* EvaluateLossCall::Start(const ServiceState& state,
                                          grpc::CallbackServerContext* context) {
  auto* call = new EvaluateLossCall(state, context);
  const absl::Status entered = call->Enter();
  if (entered.ok()) {
    call->StartRead(&call->chunk_);
  } else {
    call->End(entered);
  }
  return call;
}

EvaluateLossCall::EvaluateLossCall(const ServiceState& state, grpc::CallbackServerContext* context)
    : state_(state),
      context_(context),
      record_(state, context, "EvaluateLoss"),
      request_(MaxRequestBytes(state.auth->session_limits()), state.budget),
      decoded_(state.budget),
      reply_(state.budget) {}

absl::Status EvaluateLossCall::Enter() {
  ASSIGN_OR_RETURN(sessions_, state_.auth->Enter(*context_));
  return sessions_->CheckRate();
}

void EvaluateLossCall::End(const absl::Status& status) {
  Finish(record_.End(absl::IsCancelled(status) ? CancelledCall(*context_) : status));
}

void EvaluateLossCall::OnReadDone(bool ok) {
  if (ok) sessions_->Receive(static_cast<int64_t>(chunk_.ByteSizeLong()));
  const absl::Status read = ok ? request_.Add(chunk_.total_bytes(), chunk_.data()) : QueueDecode();
  if (!read.ok()) return End(read);
  if (ok) StartRead(&chunk_);
}

absl::Status EvaluateLossCall::QueueDecode() {
  RETURN_IF_ERROR(request_.CheckComplete());
  return state_.scheduler->decodes.Run(absl::StrCat(reinterpret_cast<uintptr_t>(this)), [this] {
    const absl::Status decoded = Decode();
    if (!decoded.ok()) End(decoded);
  });
}

absl::Status EvaluateLossCall::Decode() {
  RETURN_IF_ERROR(state_.streams->CheckServing());
  if (context_->IsCancelled()) return absl::CancelledError("cancelled");
  v1::EvaluateLossRequest request;
  const std::string bytes = request_.TakeBytes();
  // The message, and what is read from it.
  RETURN_IF_ERROR(decoded_.Grow(2 * static_cast<int64_t>(bytes.size())));
  RETURN_IF_ERROR(ParseParts("data", bytes, &request));
  ASSIGN_OR_RETURN(query_, FromProto(&request));
  ASSIGN_OR_RETURN(const auto ledger, sessions_->Find(query_.session_id));
  if (query_.frame.has_value()) {
    const SessionLimits& limits = sessions_->limits();
    RETURN_IF_ERROR(
        CheckFrameBytes("frame.data", query_.frame->bytes.size(), limits.max_frame_bytes));
    const std::vector<Camera>& cameras = ledger->config().cameras;
    RETURN_IF_ERROR(decoded_.Grow(DecodedMaskBytes(query_.frame->stated_masks, cameras)));
    DecodeLimits decode = limits.decode;
    decode.reserve = [this](int64_t bytes) { return decoded_.Grow(kDecodeFactor * bytes); };
    DecodeFrame(decode, cameras, state_.clock, &*query_.frame);
    RETURN_IF_ERROR(query_.frame->cloud.status());
    query_.frame->bytes = std::string();
  }
  // The vertices are counted with the request.
  decoded_.ShrinkTo(query_.frame.has_value() ? HeldBytes(*query_.frame) : 0);
  return sessions_->RunFit(
      [this, priority = ledger->config().priority](WorkerPool::Task task) {
        return state_.scheduler->fits.Run(query_.session_id, std::move(task), priority);
      },
      [this] { Reply(); }, [this](const absl::Status& refused) { End(refused); });
}

absl::StatusOr<Loss> EvaluateLossCall::Evaluate() const {
  const auto cancelled = [this] { return context_->IsCancelled(); };
  if (cancelled()) return absl::CancelledError("cancelled");
  ASSIGN_OR_RETURN(SessionLease session, sessions_->Lease(query_.session_id));
  RETURN_IF_ERROR(session.Reserve(SessionLease::Work::kEvaluateLoss,
                                  query_.frame.has_value() ? query_.frame->cloud->size() : 0));
  return session->EvaluateLoss(query_.vertices, query_.frame.has_value() ? &*query_.frame : nullptr,
                               cancelled);
}

void EvaluateLossCall::Reply() {
  const absl::StatusOr<Loss> loss = Evaluate();
  if (!loss.ok()) return End(loss.status());
  const absl::Status taken = reply_.Set(ToProto(*loss).SerializeAsString());
  if (!taken.ok()) return End(taken);
  StartWrite(reply_.Next());
}

void EvaluateLossCall::OnWriteDone(bool ok) {
  if (!ok) return End(absl::CancelledError("the client is gone"));
  if (reply_.is_sent()) return End(absl::OkStatus());
  StartWrite(reply_.Next());
}

}  // namespace cagefit::server
