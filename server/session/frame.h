// A frame on its way in: the client's bytes, decoded ahead of the fit.
#ifndef CAGEFIT_SERVER_SESSION_FRAME_H_
#define CAGEFIT_SERVER_SESSION_FRAME_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "core/cloud/point_cloud.h"
#include "core/codec/draco_codec.h"
#include "core/fit/fitter.h"
#include "core/fit/frame_source.h"
#include "core/image/camera.h"
#include "core/mesh/triangle_mesh.h"
#include "server/session/digest.h"
#include "server/session/frame_masks.h"

namespace cagefit::server {

struct Frame {
  uint64_t sequence_number = 0;
  std::optional<absl::Time> timestamp;  // of the capture; returned in the reply
  uint64_t point_count = 0;             // that the bytes must hold; 0: not stated
  std::string bytes;                    // Draco, then the PNG of every mask
  std::vector<StatedMask> stated_masks;
  std::vector<Landmark> landmarks;  // of the session's template: not checked

  // Where the request has them, for errors.
  const char* header_field = "header";
  const char* bytes_field = "chunk.data";

  // Filled by HashFrame.
  Digest digest{};  // of all bytes, and of what is stated beside them

  // Filled by DecodeFrame.
  uint64_t geometry_bytes = 0;  // that the masks follow
  absl::StatusOr<PointCloud> cloud = absl::UnknownError("not decoded");
  std::optional<TriangleMesh> mesh;  // where the geometry is one; `cloud` is its surface
  std::vector<Image> masks;          // by camera: empty where there is none
  double decode_ms = 0;

  double queue_ms = 0;  // waited for a worker so far

  absl::string_view geometry() const {  // Draco; once decoded
    return absl::string_view(bytes).substr(0, geometry_bytes);
  }
};

// What is left of a frame that was not begun before a newer one came.
struct SkippedFrame {
  uint64_t sequence_number = 0;
  std::optional<absl::Time> timestamp;
  Digest digest{};
};

void HashFrame(Frame* frame);

// Hashes, where that is not done yet, and decodes `frame->bytes`, and estimates normals where the
// cloud has none. Masks are of `cameras`. A frame that is broken keeps its error in `cloud`.
void DecodeFrame(const DecodeLimits& limits, const std::vector<Camera>& cameras,
                 const ClockFn& clock, Frame* frame);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_FRAME_H_
