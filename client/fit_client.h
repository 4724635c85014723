// A rig's side of the service: makes sessions, streams frames in and takes fitted control vertices
// out.
//
//   auto client = FitClient::Connect({.address = "rig:50051"});
//   auto session = client->CreateSession(request);
//   auto stream = client->OpenStream(session->session_id());
//   thread A: stream->Send(frame) ...; stream->CloseSending();
//   thread B: while (auto frame = stream->Receive(); frame.ok() && frame->has_value()) { ... }
#ifndef CAGEFIT_CLIENT_FIT_CLIENT_H_
#define CAGEFIT_CLIENT_FIT_CLIENT_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "cagefit/v1/fitting.pb.h"
#include "client/credentials.h"
#include "client/retry_policy.h"
#include "core/base/types.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::client {

struct ClientOptions {
  std::string address;  // HOST:PORT or unix:PATH
  absl::Duration connect_timeout = absl::Seconds(5);
  ClientCredentials credentials = {};
};

struct OutgoingMask {
  std::string camera;  // its name in the session's options
  std::string png;
};

struct OutgoingFrame {
  std::string draco;
  std::vector<OutgoingMask> masks;  // of cameras that saw the frame
  std::vector<v1::Landmark> landmarks;
  uint64_t sequence_number = 0;
  uint64_t point_count = 0;  // 0: not stated
  std::optional<absl::Time> timestamp;
};

struct FittedFrame {
  v1::FrameReply reply;       // its delta is already applied
  Points3d control_vertices;  // 3 x n, user units: the state after this frame; unchanged by a
                              // rejected or skipped one
  absl::Status status;        // the reply's error as a status; ABORTED when skipped, OK when fitted
};

// One FitFrames stream. Send and CloseSending from one thread, Receive from another, Cancel from
// any. It ends with its connection; client/resuming_stream.h is the one that goes on.
class FrameStream {
 public:
  ~FrameStream();  // cancels what is still running

  // Waits for the server's answer; once, before anything else but Cancel.
  absl::Status Open();

  uint64_t next_sequence_number() const;  // as the server said when the stream opened
  int frames_in_flight() const;           // likewise

  // Blocks while the server does not read, or while frames_in_flight + 1 frames are unanswered
  // (back-pressure), so another thread has to receive. An error means that the stream has ended;
  // Receive says why.
  absl::Status Send(const OutgoingFrame& frame);
  absl::Status CloseSending();

  // The next reply in frame order; nullopt once the server has answered everything and ended the
  // stream with OK. DATA_LOSS when a delta does not reproduce the server's checksum.
  absl::StatusOr<std::optional<FittedFrame>> Receive();

  void Cancel();

 private:
  friend class FitClient;
  struct Call;
  explicit FrameStream(std::unique_ptr<Call> call);
  std::unique_ptr<Call> call_;
};

// Thread-safe.
class FitClient {
 public:
  // UNAVAILABLE, naming the address, when nobody answers within the time-out; errors of OpenChannel
  // for credentials that cannot be used.
  static absl::StatusOr<std::unique_ptr<FitClient>> Connect(const ClientOptions& options);
  ~FitClient();

  // Streams the request when it is too large for one message.
  absl::StatusOr<v1::Session> CreateSession(const v1::CreateSessionRequest& request);
  absl::StatusOr<v1::Session> GetSession(const std::string& session_id);
  absl::StatusOr<std::vector<v1::Session>> ListSessions();  // all pages
  absl::Status DeleteSession(const std::string& session_id);

  absl::StatusOr<ControlMesh> GetControlMesh(const v1::GetControlMeshRequest& request);
  absl::StatusOr<std::string> GetSurface(const v1::GetSurfaceRequest& request);  // Draco mesh

  absl::StatusOr<v1::Stencils> GetStencils(const v1::GetStencilsRequest& request);
  absl::StatusOr<v1::EvaluateLossReply> EvaluateLoss(const v1::EvaluateLossRequest& request);

  // A stream that is not open yet; it ends with DEADLINE_EXCEEDED.
  std::unique_ptr<FrameStream> StartStream(const std::string& session_id,
                                           v1::FrameMode mode = v1::FRAME_MODE_EVERY,
                                           absl::Time deadline = absl::InfiniteFuture());
  absl::StatusOr<std::unique_ptr<FrameStream>> OpenStream(
      const std::string& session_id, v1::FrameMode mode = v1::FRAME_MODE_EVERY);

  // Stored replies in order, each as it came by the stream but marked as repeated. Where the call
  // breaks, it goes on behind the last one, as `retry` says. An error that `take` returns ends it
  // and is returned.
  absl::Status GetReplies(v1::GetRepliesRequest request,
                          const std::function<absl::Status(FittedFrame)>& take,
                          const RetryOptions& retry = {});

  // Whether the server says that it serves: "" for its process, "cagefit.v1.Fitting" for being
  // ready. NOT_FOUND for a service that it does not know.
  absl::StatusOr<bool> IsServing(const std::string& service, absl::Duration timeout);

 private:
  struct Connection;
  explicit FitClient(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_FIT_CLIENT_H_
