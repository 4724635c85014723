// Puts frames together from the headers and chunks of a stream.
#ifndef CAGEFIT_SERVER_TRANSPORT_FRAME_ASSEMBLER_H_
#define CAGEFIT_SERVER_TRANSPORT_FRAME_ASSEMBLER_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "cagefit/v1/fitting.pb.h"
#include "server/session/frame.h"
#include "server/session/memory_account.h"

namespace cagefit::server {

inline constexpr size_t kMaxChunkBytes = 1 << 20;

// A frame that is complete, and the share of the budget that it holds.
struct ReceivedFrame {
  Frame frame;
  MemoryReservation reservation;
  double complete_ms = 0;  // when it was
};

// INVALID_ARGUMENT naming `field` for a value that is not known.
absl::Status CheckEncoding(const std::string& field, v1::FrameEncoding encoding);
// RESOURCE_EXHAUSTED naming `field` above the limit on a frame's bytes.
absl::Status CheckFrameBytes(const std::string& field, uint64_t bytes, int64_t max_frame_bytes);

template <typename Masks>  // of v1::Mask
std::vector<StatedMask> FromProto(const Masks& protos) {
  std::vector<StatedMask> masks;
  for (const v1::Mask& proto : protos) masks.push_back({proto.camera(), proto.png_bytes()});
  return masks;
}

// INVALID_ARGUMENT naming `field` and the landmark that has no place, or one that no mesh can have;
// RESOURCE_EXHAUSTED above kMaxLandmarks.
absl::StatusOr<std::vector<Landmark>> LandmarksFromProto(
    const std::string& field, const google::protobuf::RepeatedPtrField<v1::Landmark>& protos);
inline constexpr int kMaxLandmarks = 10'000;

class FrameAssembler {
 public:
  // `budget` must outlive the assembler and its frames.
  FrameAssembler(int64_t max_frame_bytes, MemoryAccount* budget);

  // Takes a header or a chunk (its bytes are moved out); returns the frame that it completes.
  // INVALID_ARGUMENT, reason PROTOCOL_VIOLATION, for a message that may not come here;
  // RESOURCE_EXHAUSTED for a frame above the limit, or without room in the budget.
  absl::StatusOr<std::optional<ReceivedFrame>> Add(v1::FitFramesRequest* request);

  // INVALID_ARGUMENT when a frame has begun and is not complete: the stream must not end here.
  absl::Status CheckBetweenFrames() const;

 private:
  absl::Status Begin(const v1::FrameHeader& header);
  absl::Status Append(v1::FrameChunk* chunk);

  const int64_t max_frame_bytes_;
  MemoryAccount* const budget_;
  std::optional<ReceivedFrame> current_;
  uint64_t total_bytes_ = 0;  // of the current frame, as its header says
};

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_TRANSPORT_FRAME_ASSEMBLER_H_
