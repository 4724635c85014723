// Clients that load a server, and what they see of it. Straight on the generated stub: no retries,
// no resuming.
#ifndef CAGEFIT_TESTS_LOAD_LOAD_CLIENT_H_
#define CAGEFIT_TESTS_LOAD_LOAD_CLIENT_H_

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "cagefit/v1/fitting.grpc.pb.h"

namespace cagefit::testing {

// A connection of its own, shared with nobody.
std::unique_ptr<v1::Fitting::Stub> ConnectAlone(const std::string& address);

// As many open files as the system allows: a connection is one.
void RaiseFileLimit();

// A call's end, with the reason and retry time of its error detail.
struct CallEnd {
  grpc::StatusCode code = grpc::StatusCode::OK;
  std::string message, reason;
  absl::Duration retry_after = absl::ZeroDuration();

  bool ok() const { return code == grpc::StatusCode::OK; }
};
CallEnd EndOf(const grpc::Status& status, const grpc::ClientContext& context);
std::ostream& operator<<(std::ostream& out, const CallEnd& end);

// A cage of 10 * 4^levels + 2 control vertices around the first clouds of the moving sequence. An
// empty id when it was refused; `end` says why.
std::string MakeSession(v1::Fitting::Stub* stub, int levels, v1::Priority priority, CallEnd* end);

// One FitFrames stream. A frame that does not get through ends it. One thread may send while
// another receives.
class LoadStream {
 public:
  LoadStream(v1::Fitting::Stub* stub, const std::string& session_id,
             v1::FrameMode mode = v1::FRAME_MODE_EVERY);
  ~LoadStream();

  // The server's answer to the opening.
  bool Open(v1::StreamOpened* opened);
  // Waits while as many frames as the server takes, and one on its way, are unanswered.
  bool Send(uint64_t number, const std::string& draco);
  bool Receive(v1::FrameReply* reply);
  void CloseSending() { stream_->WritesDone(); }
  void Cancel() { context_.TryCancel(); }
  // Once, after the last Receive.
  CallEnd Finish();

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::FitFramesRequest, v1::FitFramesReply>> stream_;
  bool is_finished_ = false;

  std::mutex mutex_;
  std::condition_variable room_;
  int64_t window_ = 1, unanswered_ = 0;
  bool has_ended_ = false;
};

// The moving sequence, encoded once and sent again and again.
class FrameLoop {
 public:
  FrameLoop(int frames, int64_t points);
  const std::string& At(uint64_t number) const { return frames_[number % frames_.size()]; }

 private:
  std::vector<std::string> frames_;
};

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_LOAD_LOAD_CLIENT_H_
