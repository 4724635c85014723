#include "server/transport/frame_assembler.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "server/session/error_detail.h"
#include "server/transport/time_convert.h"

namespace cagefit::server {
namespace {

absl::Status Violation(const std::string& field, const std::string& message) {
  return WithDetail(absl::InvalidArgumentError(absl::StrCat(field, ": ", message)),
                    {"PROTOCOL_VIOLATION", field, "", ""});
}

}  // namespace

absl::Status CheckEncoding(const std::string& field, v1::FrameEncoding encoding) {
  if (encoding == v1::FRAME_ENCODING_UNSPECIFIED || encoding == v1::FRAME_ENCODING_DRACO) {
    return absl::OkStatus();
  }
  return InvalidField(field, absl::StrCat(encoding), "this server does not know that value");
}

absl::Status CheckFrameBytes(const std::string& field, uint64_t bytes, int64_t max_frame_bytes) {
  if (bytes <= static_cast<uint64_t>(max_frame_bytes)) return absl::OkStatus();
  return LimitExceeded(field, bytes, max_frame_bytes);
}

absl::StatusOr<std::vector<Landmark>> LandmarksFromProto(
    const std::string& field, const google::protobuf::RepeatedPtrField<v1::Landmark>& protos) {
  if (protos.size() > kMaxLandmarks) {
    return LimitExceeded(field, static_cast<uint64_t>(protos.size()), kMaxLandmarks);
  }
  constexpr uint32_t kMost = std::numeric_limits<int32_t>::max();
  std::vector<Landmark> landmarks;
  for (const v1::Landmark& proto : protos) {
    const std::string element = absl::StrCat(field, "[", landmarks.size(), "]");
    Landmark landmark;
    landmark.position = {proto.x(), proto.y(), proto.z()};
    const v1::SurfacePlace& surface = proto.surface();
    if (proto.place_case() == v1::Landmark::PLACE_NOT_SET) {
      return InvalidField(absl::StrCat(element, ".place"), "not set", "vertex or surface");
    }
    const uint32_t index = std::max(proto.vertex(), surface.triangle());  // the other is 0
    if (index > kMost) {
      return InvalidField(
          absl::StrCat(element, proto.has_vertex() ? ".vertex" : ".surface.triangle"),
          absl::StrCat(index), "no mesh has as many");
    }
    if (proto.has_vertex()) {
      landmark.vertex = static_cast<int32_t>(proto.vertex());
    } else {
      landmark.at = {static_cast<int32_t>(surface.triangle()), surface.u(), surface.v()};
    }
    landmarks.push_back(landmark);
  }
  return landmarks;
}

FrameAssembler::FrameAssembler(int64_t max_frame_bytes, MemoryAccount* budget)
    : max_frame_bytes_(max_frame_bytes), budget_(budget) {}

absl::StatusOr<std::optional<ReceivedFrame>> FrameAssembler::Add(v1::FitFramesRequest* request) {
  switch (request->message_case()) {
    case v1::FitFramesRequest::kHeader:
      RETURN_IF_ERROR(Begin(request->header()));
      break;
    case v1::FitFramesRequest::kChunk:
      RETURN_IF_ERROR(Append(request->mutable_chunk()));
      break;
    case v1::FitFramesRequest::kOpen:
      return Violation("open", "the stream is open already");
    case v1::FitFramesRequest::MESSAGE_NOT_SET:
      return Violation("message", "expected open, header or chunk");
  }
  if (current_->frame.bytes.size() < total_bytes_) return std::nullopt;
  return std::exchange(current_, std::nullopt);
}

absl::Status FrameAssembler::Begin(const v1::FrameHeader& header) {
  RETURN_IF_ERROR(CheckBetweenFrames());
  RETURN_IF_ERROR(CheckEncoding("header.encoding", header.encoding()));
  RETURN_IF_ERROR(CheckFrameBytes("header.total_bytes", header.total_bytes(), max_frame_bytes_));
  RETURN_IF_ERROR(CheckTimestamp("header.timestamp", header.timestamp()));
  ASSIGN_OR_RETURN(std::vector<Landmark> landmarks,
                   LandmarksFromProto("header.landmarks", header.landmarks()));
  ReceivedFrame received{Frame(), MemoryReservation(budget_)};
  RETURN_IF_ERROR(
      received.reservation.Grow(static_cast<int64_t>(landmarks.size() * sizeof(Landmark))));
  current_ = std::move(received);
  current_->frame.landmarks = std::move(landmarks);
  total_bytes_ = header.total_bytes();
  current_->frame.sequence_number = header.sequence_number();
  current_->frame.point_count = header.point_count();
  current_->frame.stated_masks = FromProto(header.masks());
  if (header.has_timestamp()) current_->frame.timestamp = FromProto(header.timestamp());
  return absl::OkStatus();
}

absl::Status FrameAssembler::Append(v1::FrameChunk* chunk) {
  if (!current_.has_value()) return Violation("chunk", "a frame begins with its header");
  const std::string& data = chunk->data();
  if (data.empty() || data.size() > kMaxChunkBytes) {
    return InvalidField("chunk.data", absl::StrCat(data.size(), " bytes long"),
                        absl::StrCat("expected 1 to ", kMaxChunkBytes));
  }
  std::string& bytes = current_->frame.bytes;
  if (data.size() > total_bytes_ - bytes.size()) {
    return InvalidField("chunk.data", absl::StrCat(bytes.size() + data.size(), " bytes in all"),
                        absl::StrCat("header.total_bytes is ", total_bytes_));
  }
  RETURN_IF_ERROR(current_->reservation.Grow(static_cast<int64_t>(data.size())));
  if (bytes.empty()) {
    bytes = std::move(*chunk->mutable_data());
  } else {
    bytes.append(data);
  }
  return absl::OkStatus();
}

absl::Status FrameAssembler::CheckBetweenFrames() const {
  if (!current_.has_value()) return absl::OkStatus();
  return Violation("chunk",
                   absl::StrCat("frame ", current_->frame.sequence_number, " has ",
                                current_->frame.bytes.size(), " of ", total_bytes_, " bytes"));
}

}  // namespace cagefit::server
