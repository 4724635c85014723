// A frame on its way in: the client's bytes, decoded ahead of the fit.
#ifndef CAGEFIT_SERVER_SESSION_FRAME_H_
#define CAGEFIT_SERVER_SESSION_FRAME_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/cloud/point_cloud.h"
#include "core/codec/draco_codec.h"
#include "core/fit/fitter.h"
#include "server/session/digest.h"

namespace cagefit::server {

struct Frame {
  uint64_t sequence_number = 0;
  std::optional<absl::Time> timestamp;  // of the capture; returned in the reply
  uint64_t point_count = 0;             // that the bytes must hold; 0: not stated
  std::string bytes;                    // Draco

  // Where the request has them, for errors.
  const char* header_field = "header";
  const char* bytes_field = "chunk.data";

  // Filled by DecodeFrame.
  Digest digest{};
  absl::StatusOr<PointCloud> cloud = absl::UnknownError("not decoded");
  double decode_ms = 0;

  double queue_ms = 0;  // waited for a worker so far
};

// Hashes and decodes `frame->bytes`, and estimates normals where the cloud has none. A frame that
// is broken keeps its error in `cloud`.
void DecodeFrame(const DecodeLimits& limits, const ClockFn& clock, Frame* frame);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_FRAME_H_
