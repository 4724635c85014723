// A FitFrames stream that outlives its connection, and its server.
//
// Every frame is kept until it is answered. When the stream breaks, a new one is opened and what is
// unanswered is sent again; a frame whose reply was lost gets its stored one. So the application
// sees one sequence of replies: each frame once, in order, with the control vertices of an
// undisturbed stream.
#ifndef CAGEFIT_CLIENT_RESUMING_STREAM_H_
#define CAGEFIT_CLIENT_RESUMING_STREAM_H_

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "client/fit_client.h"
#include "client/retry_policy.h"

namespace cagefit::client {

struct ResumeOptions {
  v1::FrameMode mode = v1::FRAME_MODE_EVERY;
  RetryOptions retry;
  // Called by the thread that opens or receives when the stream broke and is tried again.
  std::function<void(const absl::Status&)> on_break;
  // Waits before a try; empty: as long as it takes, and Cancel ends it.
  std::function<void(absl::Duration)> sleep;
};

// First Open. Then Send and CloseSending from one thread, Receive from another. Cancel from any, at
// any time.
class ResumingStream {
 public:
  // `client` must outlive the stream.
  ResumingStream(FitClient* client, std::string session_id, ResumeOptions options = {});
  ~ResumingStream();  // cancels what is still running
  ResumingStream(const ResumingStream&) = delete;
  ResumingStream& operator=(const ResumingStream&) = delete;

  // Tries until the stream is open, as long as RetryOptions say.
  absl::Status Open();

  uint64_t next_sequence_number() const { return first_number_; }  // when it opened first

  // Takes one frame more; the first has a sequence_number of at most next_sequence_number(), each
  // further one that of the frame before it plus 1. Blocks while frames_in_flight + 1 frames are
  // unanswered, so another thread has to receive. An error means that the stream has ended for
  // good; Receive says why.
  absl::Status Send(OutgoingFrame frame);
  absl::Status CloseSending();

  // The next reply in frame order; nullopt once everything is answered after CloseSending. Broken
  // streams are resumed in here. Errors are final: the server's, the last one after trying for too
  // long, CANCELLED after Cancel, and DATA_LOSS when the server expects a frame that was answered,
  // or answers one that was not sent.
  absl::StatusOr<std::optional<FittedFrame>> Receive();

  void Cancel();

 private:
  using Frame = std::shared_ptr<const OutgoingFrame>;

  // On a thread of its own: what is unanswered, onto the stream that there is.
  void WriteFrames();
  // Waits for the writer to let go of the stream, and ends it.
  void DropStream();
  // Opens streams until one is good; `broken` is how the last one ended, OK when there was none.
  absl::Status Reopen(absl::Status broken);
  absl::Status TryOpen();
  absl::Status Resume(const FrameStream& stream);
  absl::Status Pause(const absl::Status& failure);
  absl::StatusOr<std::optional<FittedFrame>> Deliver(FittedFrame frame);
  bool IsComplete();
  absl::Status End(absl::Status status);

  FitClient* const client_;
  const std::string session_id_;
  const ResumeOptions options_;

  // Of the receiving thread.
  RetryPolicy retry_;
  Points3d vertices_;  // after the last fitted frame
  uint64_t first_number_ = 0;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::unique_ptr<FrameStream> stream_;  // replaced by the receiving thread while nobody writes
  bool writable_ = false;                // the stream is open and takes frames
  bool writing_ = false;                 // the writer uses it
  std::deque<Frame> unanswered_;
  uint64_t answered_ = 0, written_ = 0;  // frames; those written on this stream and before
  size_t most_unanswered_ = 0;           // 0: not opened yet
  uint64_t next_number_ = 0;             // of the frame that is sent next
  bool closing_ = false, closed_ = false, cancelled_ = false;
  std::optional<absl::Status> end_;  // final
  std::thread writer_;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_RESUMING_STREAM_H_
