#include "server/transport/fit_frames_call.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"
#include "server/session/fail_point.h"
#include "server/session/session_memory.h"
#include "server/transport/frame_log.h"
#include "server/transport/message_parts.h"
#include "server/transport/reply_convert.h"
#include "server/transport/status_convert.h"

namespace cagefit::server {
namespace {

// Complete frames in FRAME_MODE_LATEST that wait to be hashed: hashing is faster than a network.
constexpr int kMaxArriving = 2;

}  // namespace

FitFramesCall* FitFramesCall::Start(const ServiceState* state,
                                    grpc::CallbackServerContext* context) {
  std::shared_ptr<FitFramesCall> call(new FitFramesCall(state, context));
  call->self_ = call;
  absl::Status added = call->sessions_.status();
  if (added.ok()) added = state->streams->Add(call);
  std::lock_guard<std::mutex> lock(call->mutex_);
  if (added.ok()) {
    call->ReadOn();
  } else {
    call->EndNow(added);
  }
  return call.get();
}

FitFramesCall::FitFramesCall(const ServiceState* state, grpc::CallbackServerContext* context)
    : state_(state),
      sessions_(state->auth->Enter(*context)),
      context_(context),
      record_(*state, context, "FitFrames"),
      deadline_(absl::FromChrono(context->deadline())),
      key_(absl::StrCat(reinterpret_cast<uintptr_t>(this))),
      assembler_(state->auth->session_limits().max_frame_bytes, state->budget) {}

void FitFramesCall::OnReadDone(bool ok) {
  const std::shared_ptr<FitFramesCall> self = shared_from_this();
  // Nobody else looks at what was read.
  const auto bytes = ok ? static_cast<int64_t>(request_.Length()) : 0;
  v1::FitFramesRequest request;
  const absl::Status parsed = ok ? ParseParts("message", request_, &request) : absl::OkStatus();
  request_.Clear();
  std::lock_guard<std::mutex> lock(mutex_);
  reading_ = false;
  if (end_.has_value()) return;
  if (!ok) {
    // The client has closed its side, or is gone, which OnCancel says.
    EndAfterFrames(ledger_ == nullptr
                       ? InvalidField("open", "not sent", "expected it as the first message")
                       : assembler_.CheckBetweenFrames());
    return;
  }
  const absl::Duration wait = sessions_->Receive(bytes);
  const absl::Status taken = parsed.ok() ? Take(&request) : parsed;
  if (!taken.ok()) EndAfterFrames(taken);
  if (wait > absl::ZeroDuration()) Pause(wait);
  ReadOn();
}

absl::Status FitFramesCall::Take(v1::FitFramesRequest* request) {
  if (ledger_ == nullptr) {
    if (request->has_open()) {
      RETURN_IF_ERROR(SetMode(request->open().mode()));
      return StartOpening(request->open().session_id());
    }
    return WithDetail(absl::InvalidArgumentError("open: expected as the first message"),
                      {"PROTOCOL_VIOLATION", "open", "", ""});
  }
  ASSIGN_OR_RETURN(std::optional<ReceivedFrame> received, assembler_.Add(request));
  return received.has_value() ? Submit(*std::move(received)) : absl::OkStatus();
}

absl::Status FitFramesCall::SetMode(v1::FrameMode mode) {
  if (!v1::FrameMode_IsValid(mode)) {
    return InvalidField("open.mode", absl::StrCat(mode), "this server does not know that value");
  }
  is_latest_ = mode == v1::FRAME_MODE_LATEST;
  return absl::OkStatus();
}

absl::Status FitFramesCall::StartOpening(const std::string& session_id) {
  // The journal writes to a disk.
  RETURN_IF_ERROR(state_->scheduler->decodes.Run(
      key_, [self = shared_from_this(), session_id] { self->Open(session_id); }));
  opening_ = true;
  return absl::OkStatus();
}

void FitFramesCall::Open(const std::string& session_id) {
  const std::weak_ptr<FitFramesCall> weak = weak_from_this();
  auto opened = sessions_->OpenStream(session_id, [weak](const absl::Status& status) {
    if (const auto call = weak.lock()) call->Stop(status);
  });
  std::lock_guard<std::mutex> lock(mutex_);
  opening_ = false;
  if (!opened.ok()) return EndNow(opened.status());
  ledger_ = std::move(opened->ledger);
  epoch_ = opened->opening.epoch;
  record_.SetSession(session_id);
  if (end_.has_value()) return MoveOn();  // overtaken or gone meanwhile
  v1::FitFramesReply reply;
  v1::StreamOpened* message = reply.mutable_opened();
  message->set_epoch(epoch_);
  message->set_next_sequence_number(opened->opening.next_sequence_number);
  message->set_frames_in_flight(FramesInFlight());
  Outgoing outgoing;
  outgoing.message = Serialized(reply);
  Send(std::move(outgoing));
  ReadOn();
}

absl::Status FitFramesCall::Submit(ReceivedFrame received) {
  received.complete_ms = state_->clock();
  auto shared = std::make_shared<ReceivedFrame>(std::move(received));
  if (is_latest_) {
    RETURN_IF_ERROR(state_->scheduler->decodes.Run(
        key_, [self = shared_from_this(), shared] { self->Arrive(shared); },
        ledger_->config().priority));
    ++arriving_;
  } else {
    RETURN_IF_ERROR(QueueDecode(std::move(shared)));
  }
  ++in_flight_;
  return absl::OkStatus();
}

absl::Status FitFramesCall::QueueDecode(std::shared_ptr<ReceivedFrame> received) {
  return state_->scheduler->decodes.Run(
      key_, [self = shared_from_this(), received] { self->Decode(received); },
      ledger_->config().priority);
}

void FitFramesCall::Arrive(std::shared_ptr<ReceivedFrame> received) {
  if (abandoned_) return;
  HashFrame(&received->frame);
  {
    std::lock_guard<std::mutex> lock(mutex_);
    --arriving_;
    latest_.Put(std::move(received));
    ReadOn();
    if (std::exchange(has_begun_, true)) return;
  }
  GoOnWithNewest();
}

void FitFramesCall::GoOnWithNewest() {
  LatestFrames::Batch batch;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    batch = latest_.Take();
    has_begun_ = batch.newest != nullptr;
  }
  // The answers of those that were overtaken, which come first; they are in the pool for fits.
  for (const SkippedFrame& frame : batch.skipped) {
    const absl::StatusOr<FrameAnswer> answer = Skip(frame);
    if (!answer.ok()) return Stop(answer.status());
    SendAnswer(*answer);
  }
  if (batch.newest == nullptr) return;
  const absl::Status queued = QueueDecode(std::move(batch.newest));
  if (!queued.ok()) Stop(queued);
}

void FitFramesCall::Decode(std::shared_ptr<ReceivedFrame> received) {
  if (abandoned_) return;
  Frame& frame = received->frame;
  frame.queue_ms = state_->clock() - received->complete_ms;
  const std::vector<Camera>& cameras = ledger_->config().cameras;
  const absl::Status room =
      received->reservation.Grow(DecodedMaskBytes(frame.stated_masks, cameras));
  if (!room.ok()) return Stop(room);
  DecodeLimits limits = sessions_->limits().decode;
  limits.reserve = [&received](int64_t bytes) {
    return received->reservation.Grow(kDecodeFactor * bytes);
  };
  DecodeFrame(limits, cameras, state_->clock, &frame);
  received->reservation.ShrinkTo(HeldBytes(frame));
  const auto self = shared_from_this();
  const absl::Status queued = sessions_->RunFit(
      [self](WorkerPool::Task task) {
        return self->state_->scheduler->fits.Run(self->ledger_->id(), std::move(task),
                                                 self->ledger_->config().priority);
      },
      [self, received, ready_ms = state_->clock()] { self->Fit(received, ready_ms); },
      [self](const absl::Status& refused) { self->Stop(refused); });
  if (!queued.ok()) Stop(queued);
}

void FitFramesCall::Fit(std::shared_ptr<ReceivedFrame> received, double ready_ms) {
  if (abandoned_) return;
  received->frame.queue_ms += state_->clock() - ready_ms;
  const absl::StatusOr<FrameAnswer> answer = Answer(std::move(received->frame));
  if (!answer.ok()) return Stop(answer.status());
  SendAnswer(*answer);
  if (is_latest_) GoOnWithNewest();
}

absl::StatusOr<FrameAnswer> FitFramesCall::Answer(Frame frame) {
  ASSIGN_OR_RETURN(SessionLease session, sessions_->Lease(ledger_->id()));
  if (frame.cloud.ok()) {
    RETURN_IF_ERROR(session.Reserve(SessionLease::Work::kFit, frame.cloud->size()));
  }
  WorkerPool& fits = state_->scheduler->fits;
  ASSIGN_OR_RETURN(
      FrameAnswer answer,
      session->Answer(std::move(frame), epoch_, [this] { return abandoned_.load(); },
                      {[&fits] { return fits.IsOvertaken(); }, [&fits] { fits.GiveWay(); }}));
  CAGEFIT_FAIL_POINT("stream.before_reply", answer.frame->sequence_number);
  return answer;
}

absl::StatusOr<FrameAnswer> FitFramesCall::Skip(const SkippedFrame& frame) {
  ASSIGN_OR_RETURN(const SessionLease session, sessions_->Lease(ledger_->id()));
  return session->Skip(frame, epoch_);
}

void FitFramesCall::SendAnswer(const FrameAnswer& answer) {
  LogFrame(*state_->log, ledger_->id(), record_.trace_id(), answer);
  state_->metrics->CountFrame(answer);
  v1::FitFramesReply reply;
  *reply.mutable_frame() = ToProto(answer, *ledger_);
  Outgoing outgoing;
  outgoing.message = Serialized(reply);
  outgoing.answers_frame = true;
  // A client that reads slowly holds memory. What it does not get now, it gets when it asks again.
  outgoing.memory.emplace(state_->budget);
  const absl::Status room = outgoing.memory->Grow(static_cast<int64_t>(outgoing.message.Length()));
  if (!room.ok()) return Stop(room);
  std::lock_guard<std::mutex> lock(mutex_);
  if (!abandoned_) Send(std::move(outgoing));
}

void FitFramesCall::Send(Outgoing outgoing) {
  outgoing_.push_back(std::move(outgoing));
  MoveOn();
}

void FitFramesCall::OnWriteDone(bool ok) {
  const std::shared_ptr<FitFramesCall> self = shared_from_this();
  std::lock_guard<std::mutex> lock(mutex_);
  writing_ = false;
  if (outgoing_.front().answers_frame) --in_flight_;
  outgoing_.pop_front();
  if (!ok) {
    outgoing_.clear();
    EndNow(absl::CancelledError("the client is gone"));
    return;
  }
  ReadOn();
  MoveOn();
}

void FitFramesCall::OnCancel() {
  const std::shared_ptr<FitFramesCall> self = shared_from_this();
  std::lock_guard<std::mutex> lock(mutex_);
  // The one that is being written stays until OnWriteDone.
  outgoing_.erase(outgoing_.begin() + (writing_ ? 1 : 0), outgoing_.end());
  EndNow(absl::CancelledError("the client cancelled the stream"));
}

void FitFramesCall::Stop(const absl::Status& status) {
  const std::shared_ptr<FitFramesCall> self = shared_from_this();
  std::lock_guard<std::mutex> lock(mutex_);
  EndNow(status);
}

void FitFramesCall::Drain(const absl::Status& status) {
  const std::shared_ptr<FitFramesCall> self = shared_from_this();
  std::lock_guard<std::mutex> lock(mutex_);
  EndAfterFrames(status);
}

void FitFramesCall::EndAfterFrames(const absl::Status& status) {
  if (!end_.has_value()) end_ = status;
  MoveOn();
}

void FitFramesCall::EndNow(const absl::Status& status) {
  // A frame's error comes before the end that was only waiting for the frames.
  if (!end_.has_value() || !abandoned_) end_ = status;
  abandoned_ = true;
  MoveOn();
}

void FitFramesCall::ReadOn() {
  if (opening_ || reading_ || paused_ || end_.has_value()) return;
  if (in_flight_ >= FramesInFlight() || arriving_ >= kMaxArriving) return;
  reading_ = true;
  StartRead(&request_);
}

void FitFramesCall::Pause(absl::Duration wait) {
  paused_ = true;
  // A new one each time: an alarm must not be set again before its last call has returned.
  resume_ = std::make_unique<grpc::Alarm>();
  resume_->Set(absl::ToChronoTime(absl::Now() + wait), [weak = weak_from_this()](bool) {
    const auto call = weak.lock();
    if (call == nullptr) return;
    std::lock_guard<std::mutex> lock(call->mutex_);
    call->paused_ = false;
    call->ReadOn();
  });
}

void FitFramesCall::MoveOn() {
  if (writing_ || finished_) return;
  if (!outgoing_.empty()) {
    writing_ = true;
    StartWrite(&outgoing_.front().message);
    return;
  }
  if (!end_.has_value() || opening_ || (in_flight_ > 0 && !abandoned_)) return;
  finished_ = true;
  abandoned_ = true;
  end_ = NamingDeadline(*end_, deadline_);
  Finish(record_.End(*end_));
}

void FitFramesCall::OnDone() {
  state_->streams->Remove(this);
  if (ledger_ != nullptr) ledger_->CloseStream(epoch_);
  const std::shared_ptr<FitFramesCall> last = std::move(self_);
}

}  // namespace cagefit::server
