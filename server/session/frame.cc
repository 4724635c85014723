#include "server/session/frame.h"

#include <new>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "core/cloud/normals.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

absl::Status CheckPointCount(const Frame& frame, int64_t decoded) {
  const int64_t stated = static_cast<int64_t>(frame.point_count);
  if (stated == 0 || stated == decoded) return absl::OkStatus();
  // Of a mesh, vertices without a normal are left out.
  const auto info = InspectDraco(frame.bytes);
  if (info.ok() && info->is_mesh && stated > decoded) return absl::OkStatus();
  return InvalidField("header.point_count", absl::StrCat(stated),
                      absl::StrCat("the bytes hold ", decoded, " points"));
}

absl::StatusOr<PointCloud> Decode(const DecodeLimits& limits, const Frame& frame) {
  if (frame.point_count > static_cast<uint64_t>(limits.max_points)) {
    return LimitExceeded("header.point_count", frame.point_count, limits.max_points);
  }
  auto decoded = DecodeDracoCloud(frame.bytes, limits);
  if (absl::IsInvalidArgument(decoded.status())) {
    return WithDetail(decoded.status(), {"BAD_FRAME", "chunk.data", "", ""});
  }
  if (absl::IsResourceExhausted(decoded.status())) {
    return WithDetail(decoded.status(), {"LIMIT_EXCEEDED", "chunk.data", "", ""});
  }
  RETURN_IF_ERROR(decoded.status());
  RETURN_IF_ERROR(CheckPointCount(frame, decoded->size()));
  absl::Status valid = ValidateTarget(*decoded);
  if (valid.ok() && !decoded->has_normals()) valid = EstimateNormals(NormalOptions(), &*decoded);
  if (!valid.ok()) return WithDetail(valid, {"BAD_FRAME", "chunk.data", "", ""});
  return decoded;
}

}  // namespace

void DecodeFrame(const DecodeLimits& limits, const ClockFn& clock, Frame* frame) {
  const double start = clock();
  frame->digest = Sha256(frame->bytes);
  try {
    frame->cloud = Decode(limits, *frame);
  } catch (const std::bad_alloc&) {
    frame->cloud = WithDetail(
        absl::ResourceExhaustedError("the server has no memory left to decode this frame"),
        {"LIMIT_EXCEEDED", "memory", "", ""});
  }
  frame->decode_ms = clock() - start;
}

}  // namespace cagefit::server
