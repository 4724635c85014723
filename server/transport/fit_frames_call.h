// One FitFrames stream: frames in, answers out, in order.
//
// Reactions and tasks only move the stream's own state along, under its mutex; hashing, decoding
// and fitting run in the scheduler's pools. At most kFramesInFlight complete frames are unanswered:
// then nothing is read, and the client feels it. In FRAME_MODE_LATEST at most kLatestInFlight are:
// one that is decoded or fitted, the newest, and what is left of those between.
#ifndef CAGEFIT_SERVER_TRANSPORT_FIT_FRAMES_CALL_H_
#define CAGEFIT_SERVER_TRANSPORT_FIT_FRAMES_CALL_H_

#include <grpcpp/alarm.h>
#include <grpcpp/grpcpp.h>

#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "cagefit/v1/fitting.grpc.pb.h"
#include "server/transport/call_record.h"
#include "server/transport/frame_assembler.h"
#include "server/transport/latest_frames.h"
#include "server/transport/service_state.h"

namespace cagefit::server {

inline constexpr int kFramesInFlight = 2;
inline constexpr int kLatestInFlight = 64;

class FitFramesCall : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                      public DrainableStream,
                      public std::enable_shared_from_this<FitFramesCall> {
 public:
  // The call owns itself until gRPC is done with it and no task holds it.
  static FitFramesCall* Start(const ServiceState* state, grpc::CallbackServerContext* context);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;
  void Drain(const absl::Status& status) override;

 private:
  struct Outgoing {
    grpc::ByteBuffer message;  // FitFramesReply
    bool answers_frame = false;
    std::optional<MemoryReservation> memory;  // of an answer
  };

  FitFramesCall(const ServiceState* state, grpc::CallbackServerContext* context);

  // Under the mutex.
  absl::Status Take(v1::FitFramesRequest* request);
  absl::Status StartOpening(const std::string& session_id);
  absl::Status SetMode(v1::FrameMode mode);
  int FramesInFlight() const { return is_latest_ ? kLatestInFlight : kFramesInFlight; }
  absl::Status Submit(ReceivedFrame received);
  void Send(Outgoing outgoing);
  void EndAfterFrames(const absl::Status& status);  // those in flight are still answered
  void EndNow(const absl::Status& status);          // only answers that wait are still sent
  void ReadOn();
  void Pause(absl::Duration wait);  // nothing is read meanwhile
  void MoveOn();                    // starts the next write, or finishes

  // In the pools.
  void Open(const std::string& session_id);
  absl::Status QueueDecode(std::shared_ptr<ReceivedFrame> received);
  void Arrive(std::shared_ptr<ReceivedFrame> received);  // in FRAME_MODE_LATEST
  void GoOnWithNewest();                                 // likewise
  void Decode(std::shared_ptr<ReceivedFrame> received);
  void Fit(std::shared_ptr<ReceivedFrame> received, double ready_ms);
  absl::StatusOr<FrameAnswer> Answer(Frame frame);
  absl::StatusOr<FrameAnswer> Skip(const SkippedFrame& frame);
  void SendAnswer(const FrameAnswer& answer);
  void Stop(const absl::Status& status);  // EndNow from outside

  const ServiceState* const state_;
  const absl::StatusOr<PrincipalSessions> sessions_;  // OK in all but the first moment
  grpc::CallbackServerContext* const context_;
  CallRecord record_;
  const absl::Time deadline_;
  const std::string key_;                // in the pool for decodes
  std::shared_ptr<FitFramesCall> self_;  // until OnDone
  std::atomic<bool> abandoned_{false};   // frames in flight are not wanted any more

  std::mutex mutex_;
  grpc::ByteBuffer request_;  // FitFramesRequest; only of the read in progress
  FrameAssembler assembler_;
  std::shared_ptr<SessionLedger> ledger_;  // once open; then constant, as is epoch_
  uint64_t epoch_ = 0;
  int in_flight_ = 0;  // complete frames whose answers are not written

  // FRAME_MODE_LATEST.
  bool is_latest_ = false;
  int arriving_ = 0;        // complete frames that are not hashed
  bool has_begun_ = false;  // a frame is decoded or fitted
  LatestFrames latest_;

  bool opening_ = false, reading_ = false, writing_ = false, finished_ = false, paused_ = false;
  std::unique_ptr<grpc::Alarm> resume_;  // of the latest pause
  std::deque<Outgoing> outgoing_;        // the first one is being written while writing_
  std::optional<absl::Status> end_;
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_FIT_FRAMES_CALL_H_
