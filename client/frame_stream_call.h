// The gRPC call behind a FrameStream.
#ifndef CAGEFIT_CLIENT_FRAME_STREAM_CALL_H_
#define CAGEFIT_CLIENT_FRAME_STREAM_CALL_H_

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "cagefit/v1/fitting.grpc.pb.h"
#include "client/delta_decoder.h"
#include "client/fit_client.h"

namespace cagefit::client {

struct FrameStream::Call {
  Call(v1::Fitting::Stub* stub, std::string session_id, v1::FrameMode mode, absl::Time deadline);
  // Opens the stream and waits for the server's answer.
  absl::Status Open();
  // Blocks until one more frame may be unanswered, and counts it.
  absl::Status WaitForRoom();
  void Answered();
  // Ends the call and lets a sender that waits for room go.
  void Cancel();
  // Fetches the status of a stream that brings no more replies.
  absl::Status End();

  v1::Fitting::Stub* const stub;
  const std::string session_id;
  const v1::FrameMode mode;
  grpc::ClientContext context;
  // From Open on, which waits for the connection.
  std::unique_ptr<grpc::ClientReaderWriter<v1::FitFramesRequest, v1::FitFramesReply>> stream;
  v1::StreamOpened opened;
  DeltaDecoder decoder;  // of the receiving thread

  std::mutex mutex;
  std::condition_variable room;
  int unanswered = 0;
  bool cancelled = false;
  std::optional<absl::Status> status;  // once the stream has ended; written by the receiving thread
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_FRAME_STREAM_CALL_H_
