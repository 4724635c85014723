#include "client/resuming_stream.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

absl::Status Cancelled() { return absl::CancelledError("the stream was cancelled"); }

// The same status and payloads, with more to read.
absl::Status Annotate(const absl::Status& status, const std::string& more) {
  absl::Status annotated(status.code(), absl::StrCat(status.message(), more));
  status.ForEachPayload([&annotated](absl::string_view type, const absl::Cord& payload) {
    annotated.SetPayload(type, payload);
  });
  return annotated;
}

}  // namespace

ResumingStream::ResumingStream(FitClient* client, std::string session_id, ResumeOptions options)
    : client_(client),
      session_id_(std::move(session_id)),
      options_(std::move(options)),
      retry_(options_.retry),
      writer_([this] { WriteFrames(); }) {}

ResumingStream::~ResumingStream() {
  Cancel();
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (!end_.has_value()) end_ = Cancelled();
    changed_.notify_all();
  }
  writer_.join();
}

absl::Status ResumingStream::Open() {
  absl::Status opened = Reopen(absl::OkStatus());
  if (!opened.ok()) return End(opened);
  return absl::OkStatus();
}

absl::Status ResumingStream::Send(OutgoingFrame frame) {
  auto kept = std::make_shared<const OutgoingFrame>(std::move(frame));
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] {
    return end_.has_value() || cancelled_ || unanswered_.size() < most_unanswered_;
  });
  if (end_.has_value() || cancelled_) {
    return absl::UnavailableError("the stream has ended; Receive says why");
  }
  next_number_ = kept->sequence_number + 1;
  unanswered_.push_back(std::move(kept));
  changed_.notify_all();
  return absl::OkStatus();
}

absl::Status ResumingStream::CloseSending() {
  std::lock_guard<std::mutex> lock(mutex_);
  closing_ = true;
  changed_.notify_all();
  return absl::OkStatus();
}

void ResumingStream::Cancel() {
  std::lock_guard<std::mutex> lock(mutex_);
  cancelled_ = true;
  if (stream_ != nullptr) stream_->Cancel();
  changed_.notify_all();
}

void ResumingStream::WriteFrames() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    const auto has_frame = [this] { return written_ < answered_ + unanswered_.size(); };
    changed_.wait(lock, [&] {
      return end_.has_value() || (writable_ && (has_frame() || (closing_ && !closed_)));
    });
    if (end_.has_value()) return;
    // A frame may be answered while it is being written, so places count from the first frame on.
    const Frame frame = has_frame() ? unanswered_[written_ - answered_] : nullptr;
    writing_ = true;
    lock.unlock();
    const absl::Status sent = frame != nullptr ? stream_->Send(*frame) : stream_->CloseSending();
    lock.lock();
    writing_ = false;
    if (!sent.ok()) {
      writable_ = false;  // until the next stream; the receiver knows why
    } else if (frame != nullptr) {
      ++written_;
    } else {
      closed_ = true;
    }
    changed_.notify_all();
  }
}

absl::StatusOr<std::optional<FittedFrame>> ResumingStream::Receive() {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (end_.has_value() && end_->ok()) return std::nullopt;
    if (end_.has_value()) return *end_;
  }
  while (true) {
    auto frame = stream_->Receive();
    if (frame.ok() && frame->has_value()) return Deliver(**std::move(frame));
    absl::Status broken = frame.status();
    if (IsComplete()) {
      // Nothing is left to ask for, whatever became of the connection.
      End(absl::OkStatus()).IgnoreError();
      return std::nullopt;
    }
    if (broken.ok()) broken = absl::UnknownError("the server ended the stream before its frames");
    if (absl::Status opened = Reopen(broken); !opened.ok()) return End(opened);
  }
}

absl::StatusOr<std::optional<FittedFrame>> ResumingStream::Deliver(FittedFrame frame) {
  {
    std::lock_guard<std::mutex> lock(mutex_);
    const uint64_t number = frame.reply.sequence_number();
    if (unanswered_.empty() || unanswered_.front()->sequence_number != number) {
      end_ = absl::DataLossError(absl::StrCat(
          "the server answers frame ", number, "; expected ",
          unanswered_.empty() ? "none"
                              : absl::StrCat("frame ", unanswered_.front()->sequence_number)));
      changed_.notify_all();
      return *end_;
    }
    unanswered_.pop_front();
    ++answered_;
    changed_.notify_all();
  }
  retry_.Progress();
  // A stream that was resumed begins to decode with its first fitted frame.
  if (frame.reply.outcome() == v1::OUTCOME_FITTED) {
    vertices_ = frame.control_vertices;
  } else {
    frame.control_vertices = vertices_;
  }
  return frame;
}

bool ResumingStream::IsComplete() {
  std::lock_guard<std::mutex> lock(mutex_);
  return closing_ && unanswered_.empty() && !cancelled_;
}

absl::Status ResumingStream::End(absl::Status status) {
  std::lock_guard<std::mutex> lock(mutex_);
  end_ = status;
  if (stream_ != nullptr) stream_->Cancel();
  changed_.notify_all();
  return status;
}

void ResumingStream::DropStream() {
  std::unique_ptr<FrameStream> dropped;
  std::unique_lock<std::mutex> lock(mutex_);
  writable_ = false;
  if (stream_ != nullptr) stream_->Cancel();
  changed_.wait(lock, [this] { return !writing_; });
  dropped = std::move(stream_);
  lock.unlock();  // a stream takes its time to end
}

absl::Status ResumingStream::Reopen(absl::Status broken) {
  while (true) {
    DropStream();
    if (!broken.ok()) RETURN_IF_ERROR(Pause(broken));
    broken = TryOpen();
    if (broken.ok()) return absl::OkStatus();
    if (!MayPass(broken)) return broken;
  }
}

absl::Status ResumingStream::Pause(const absl::Status& failure) {
  const std::optional<absl::Duration> pause = retry_.PauseAfter(failure);
  std::unique_lock<std::mutex> lock(mutex_);
  if (cancelled_) return Cancelled();
  if (!pause.has_value()) {
    const absl::Duration tried = retry_.tried_for();
    if (!MayPass(failure) || tried == absl::ZeroDuration()) return failure;
    return Annotate(failure,
                    absl::StrCat("; tried again for ",
                                 absl::FormatDuration(absl::Trunc(tried, absl::Milliseconds(1)))));
  }
  lock.unlock();
  if (options_.on_break) options_.on_break(failure);
  if (options_.sleep) {
    options_.sleep(*pause);
    return absl::OkStatus();
  }
  lock.lock();
  changed_.wait_for(lock, absl::ToChronoNanoseconds(*pause), [this] { return cancelled_; });
  return cancelled_ ? Cancelled() : absl::OkStatus();
}

absl::Status ResumingStream::TryOpen() {
  FrameStream* stream = nullptr;
  {
    std::lock_guard<std::mutex> lock(mutex_);
    if (cancelled_) return Cancelled();
    stream_ = client_->StartStream(session_id_, options_.mode, options_.retry.deadline);
    stream = stream_.get();
  }
  RETURN_IF_ERROR(stream->Open());
  return Resume(*stream);
}

absl::Status ResumingStream::Resume(const FrameStream& stream) {
  std::lock_guard<std::mutex> lock(mutex_);
  const bool is_first = most_unanswered_ == 0;
  most_unanswered_ = static_cast<size_t>(stream.frames_in_flight()) + 1;
  if (is_first) first_number_ = next_number_ = stream.next_sequence_number();
  const uint64_t needed = unanswered_.empty() ? next_number_ : unanswered_.front()->sequence_number;
  if (stream.next_sequence_number() < needed) {
    return absl::DataLossError(absl::StrCat(
        "the server expects frame ", stream.next_sequence_number(), " of session ", session_id_,
        " but has answered those before frame ", needed, ": its store has lost some"));
  }
  retry_.Opened();
  if (unanswered_.empty()) retry_.Progress();
  written_ = answered_;
  closed_ = false;
  writable_ = true;
  changed_.notify_all();
  return absl::OkStatus();
}

}  // namespace cagefit::client
