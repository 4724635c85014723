#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "client/apply_reply.h"
#include "client/delta_decoder.h"
#include "client/fit_client.h"
#include "client/frame_stream_call.h"
#include "client/session_header.h"
#include "client/status_from_grpc.h"

namespace cagefit::client {
namespace {

constexpr size_t kChunkBytes = 1 << 20;

absl::Status Ended() { return absl::UnavailableError("the stream has ended; Receive says why"); }

void Fill(absl::Time time, google::protobuf::Timestamp* proto) {
  const int64_t seconds = absl::ToUnixSeconds(time);
  proto->set_seconds(seconds);
  proto->set_nanos(
      static_cast<int32_t>(absl::ToInt64Nanoseconds(time - absl::FromUnixSeconds(seconds))));
}

}  // namespace

FrameStream::Call::Call(v1::Fitting::Stub* stub, std::string session_id, v1::FrameMode mode,
                        absl::Time deadline)
    : stub(stub), session_id(std::move(session_id)), mode(mode) {
  AddSessionHeader(this->session_id, &context);
  if (deadline != absl::InfiniteFuture()) context.set_deadline(absl::ToChronoTime(deadline));
}

absl::Status FrameStream::Call::Open() {
  stream = stub->FitFrames(&context);
  v1::FitFramesRequest open;
  open.mutable_open()->set_session_id(session_id);
  open.mutable_open()->set_mode(mode);
  v1::FitFramesReply reply;
  // A failed write shows as a failed read, which brings the status.
  stream->Write(open);
  if (!stream->Read(&reply)) return End();
  opened = reply.opened();
  return absl::OkStatus();
}

absl::Status FrameStream::Call::WaitForRoom() {
  std::unique_lock<std::mutex> lock(mutex);
  room.wait(lock, [this] {
    return status.has_value() || cancelled ||
           unanswered < static_cast<int>(opened.frames_in_flight()) + 1;
  });
  if (status.has_value() || cancelled) return Ended();
  ++unanswered;
  return absl::OkStatus();
}

absl::Status FrameStream::Call::End() {
  absl::Status ended = FromGrpc(stream->Finish(), context);
  std::lock_guard<std::mutex> lock(mutex);
  status = ended;
  room.notify_all();
  return ended;
}

void FrameStream::Call::Answered() {
  std::lock_guard<std::mutex> lock(mutex);
  --unanswered;
  room.notify_all();
}

void FrameStream::Call::Cancel() {
  context.TryCancel();
  std::lock_guard<std::mutex> lock(mutex);
  cancelled = true;
  room.notify_all();
}

FrameStream::FrameStream(std::unique_ptr<Call> call) : call_(std::move(call)) {}

FrameStream::~FrameStream() {
  call_->context.TryCancel();
  if (call_->status.has_value() || call_->stream == nullptr) return;
  // gRPC wants every call to be finished; after the cancel nothing blocks.
  v1::FitFramesReply ignored;
  while (call_->stream->Read(&ignored)) {
  }
  call_->stream->Finish();
}

absl::Status FrameStream::Open() { return call_->Open(); }

uint64_t FrameStream::next_sequence_number() const { return call_->opened.next_sequence_number(); }

int FrameStream::frames_in_flight() const {
  return static_cast<int>(call_->opened.frames_in_flight());
}

absl::Status FrameStream::Send(const OutgoingFrame& frame) {
  if (absl::Status room = call_->WaitForRoom(); !room.ok()) return room;
  v1::FitFramesRequest request;
  v1::FrameHeader* header = request.mutable_header();
  header->set_sequence_number(frame.sequence_number);
  header->set_encoding(v1::FRAME_ENCODING_DRACO);
  std::vector<absl::string_view> parts = {frame.draco};
  for (const OutgoingMask& mask : frame.masks) {
    v1::Mask* proto = header->add_masks();
    proto->set_camera(mask.camera);
    proto->set_png_bytes(mask.png.size());
    parts.push_back(mask.png);
  }
  for (const v1::Landmark& landmark : frame.landmarks) *header->add_landmarks() = landmark;
  size_t total_bytes = 0;
  for (const absl::string_view part : parts) total_bytes += part.size();
  header->set_total_bytes(total_bytes);
  header->set_point_count(frame.point_count);
  if (frame.timestamp.has_value()) Fill(*frame.timestamp, header->mutable_timestamp());
  if (!call_->stream->Write(request)) return Ended();
  for (absl::string_view part : parts) {
    for (; !part.empty(); part.remove_prefix(std::min(kChunkBytes, part.size()))) {
      const absl::string_view data = part.substr(0, kChunkBytes);
      request.mutable_chunk()->set_data(data.data(), data.size());
      if (!call_->stream->Write(request)) return Ended();
    }
  }
  return absl::OkStatus();
}

absl::Status FrameStream::CloseSending() {
  return call_->stream->WritesDone() ? absl::OkStatus() : Ended();
}

absl::StatusOr<std::optional<FittedFrame>> FrameStream::Receive() {
  if (call_->status.has_value()) {
    if (call_->status->ok()) return std::nullopt;
    return *call_->status;
  }
  v1::FitFramesReply reply;
  if (!call_->stream->Read(&reply)) {
    const absl::Status ended = call_->End();
    if (ended.ok()) return std::nullopt;
    return ended;
  }
  call_->Answered();
  auto frame = ApplyReply(std::move(*reply.mutable_frame()), &call_->decoder);
  if (frame.ok()) return *std::move(frame);
  call_->Cancel();
  return frame.status();
}

void FrameStream::Cancel() { call_->Cancel(); }

}  // namespace cagefit::client
