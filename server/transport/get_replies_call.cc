#include "server/transport/get_replies_call.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"
#include "server/session/key_answer.h"
#include "server/transport/reply_convert.h"
#include "server/transport/status_convert.h"

namespace cagefit::server {
namespace {

absl::StatusOr<std::shared_ptr<const StoredFrame>> FindAnswer(const SessionLedger& ledger,
                                                              uint64_t number) {
  ASSIGN_OR_RETURN(std::shared_ptr<const StoredFrame> answer, ledger.Find(number));
  if (answer != nullptr) return answer;
  return absl::DataLossError(absl::StrCat("the stored reply to frame ", number, " is missing"));
}

}  // namespace

GetRepliesCall* GetRepliesCall::Start(const ServiceState& state,
                                      grpc::CallbackServerContext* context,
                                      const v1::GetRepliesRequest* request) {
  auto* call = new GetRepliesCall(state, context, request);
  if (call->sessions_.ok()) {
    call->QueueNext();
  } else {
    call->Finish(call->record_.End(call->sessions_.status()));
  }
  return call;
}

GetRepliesCall::GetRepliesCall(const ServiceState& state, grpc::CallbackServerContext* context,
                               const v1::GetRepliesRequest* request)
    : state_(state),
      context_(context),
      request_(request),
      record_(state, context, "GetReplies"),
      sessions_(state.auth->Enter(*context)),
      reservation_(state.budget) {}

void GetRepliesCall::QueueNext() {
  const absl::Status queued = state_.scheduler->queries.Run(context_->peer(), [this] { Next(); });
  if (!queued.ok()) Finish(record_.End(queued));
}

void GetRepliesCall::Next() {
  absl::Status status = context_->IsCancelled() ? CancelledCall(*context_) : absl::OkStatus();
  if (status.ok() && ledger_ == nullptr) status = Begin();
  if (status.ok() && next_ == end_) return Finish(record_.End(absl::OkStatus()));
  if (status.ok()) status = MakeReply();
  if (!status.ok()) return Finish(record_.End(status));
  StartWrite(&reply_);
}

absl::Status GetRepliesCall::Begin() {
  ASSIGN_OR_RETURN(ledger_, sessions_->Find(request_->session_id()));
  next_ = request_->first();
  end_ = ledger_->Facts().next_sequence_number;
  if (next_ > end_) {
    return WithDetail(absl::OutOfRangeError(absl::StrCat(
                          "first is ", next_, "; the session has answered ", end_, " frames")),
                      {"OUT_OF_RANGE", "first", absl::StrCat(next_), absl::StrCat(end_)});
  }
  if (request_->has_count()) end_ = next_ + std::min(request_->count(), end_ - next_);
  return absl::OkStatus();
}

absl::Status GetRepliesCall::MakeReply() {
  ASSIGN_OR_RETURN(auto answer, FindAnswer(*ledger_, next_));
  if (!fitted_seen_ && answer->outcome == Outcome::kFitted) {
    ASSIGN_OR_RETURN(answer, KeyAnswer(*ledger_, std::move(answer)));
    fitted_seen_ = true;
  }
  reply_ = ToProto({std::move(answer), /*repeated=*/true}, *ledger_);
  reservation_ = MemoryReservation(state_.budget);
  RETURN_IF_ERROR(reservation_.Grow(static_cast<int64_t>(reply_.ByteSizeLong())));
  ++next_;
  return absl::OkStatus();
}

void GetRepliesCall::OnWriteDone(bool ok) {
  if (!ok) return Finish(record_.End(absl::CancelledError("the client is gone")));
  QueueNext();
}

}  // namespace cagefit::server
