#include "tests/soak/resume.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "client/fit_client.h"
#include "core/base/status.h"
#include "tests/soak/sequence.h"

namespace cagefit::testing {
namespace {

using Kind = History::Event::Kind;

bool IsWorthAnotherTry(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsInternal(status) || absl::IsUnknown(status);
}

class Client {
 public:
  explicit Client(const Resumption& resumption)
      : resumption_(resumption), next_(resumption.first) {}

  bool is_done() const { return next_ >= resumption_.frames; }
  uint64_t next() const { return next_; }

  // One stream; OK once it has answered the last frame.
  absl::Status Stream() {
    ASSIGN_OR_RETURN(const auto client,
                     client::FitClient::Connect({resumption_.address, absl::Seconds(2)}));
    ASSIGN_OR_RETURN(const auto stream, client->OpenStream(resumption_.session_id));
    ASSIGN_OR_RETURN(const v1::Session session, client->GetSession(resumption_.session_id));
    See({Kind::kOpened, stream->next_sequence_number(), session.epoch(), ""});
    std::thread sender([this, &stream, first = next_] {
      for (uint64_t k = first; k < resumption_.frames; ++k) {
        See({Kind::kSent, k, 0, ""});
        if (!stream->Send(SoakFrame(k)).ok()) return;
      }
      (void)stream->CloseSending();
    });
    const absl::Status status = Receive(stream.get());
    stream->Cancel();
    sender.join();
    return status;
  }

 private:
  absl::Status Receive(client::FrameStream* stream) {
    while (!is_done()) {
      ASSIGN_OR_RETURN(const auto frame, stream->Receive());
      if (!frame.has_value()) return absl::UnavailableError("the stream ended early");
      if (!frame->status.ok()) {
        return absl::FailedPreconditionError(absl::StrCat(
            "frame ", frame->reply.sequence_number(), " was rejected: ", frame->status.ToString()));
      }
      See({Kind::kAnswered, frame->reply.sequence_number(), 0, BitsOf(frame->control_vertices)});
      next_ = std::max(next_, frame->reply.sequence_number() + 1);
    }
    return absl::OkStatus();
  }

  void See(const History::Event& event) {
    std::lock_guard<std::mutex> lock(mutex_);
    resumption_.seen(event);
  }

  const Resumption& resumption_;
  std::mutex mutex_;
  uint64_t next_;  // of the receiving thread
};

}  // namespace

absl::Status StreamToEnd(const Resumption& resumption) {
  Client client(resumption);
  absl::Time progress = absl::Now();
  while (!client.is_done()) {
    const uint64_t before = client.next();
    const absl::Status status = client.Stream();
    if (client.is_done()) break;
    if (!IsWorthAnotherTry(status)) return status;
    if (client.next() > before) progress = absl::Now();
    if (absl::Now() - progress > resumption.patience) {
      return absl::DeadlineExceededError(absl::StrCat("no answer to frame ", client.next(), " for ",
                                                      absl::FormatDuration(resumption.patience),
                                                      ": ", status.ToString()));
    }
    absl::SleepFor(absl::Milliseconds(5));
  }
  return absl::OkStatus();
}

}  // namespace cagefit::testing
