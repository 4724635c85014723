#include "server/session/frame.h"

#include <new>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "core/cloud/normals.h"
#include "core/cloud/surface_cloud.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

// The cloud, or the surface of a mesh; `held` is the number of points that the bytes hold.
absl::StatusOr<PointCloud> DecodeTarget(absl::string_view bytes, const DecodeLimits& limits,
                                        int64_t* held) {
  ASSIGN_OR_RETURN(const DracoInfo info, InspectDraco(bytes));
  if (!info.is_mesh) {
    ASSIGN_OR_RETURN(PointCloud cloud, DecodeDracoCloud(bytes, limits));
    *held = cloud.size();
    return cloud;
  }
  Points3f normals;
  ASSIGN_OR_RETURN(const TriangleMesh mesh, DecodeDracoMesh(bytes, limits, &normals));
  *held = mesh.vertices.cols();
  return SurfaceCloud(mesh, normals);
}

absl::StatusOr<PointCloud> Decode(const DecodeLimits& limits, const Frame& frame) {
  if (frame.point_count > static_cast<uint64_t>(limits.max_points)) {
    return LimitExceeded(absl::StrCat(frame.header_field, ".point_count"), frame.point_count,
                         limits.max_points);
  }
  int64_t held = 0;
  auto decoded = DecodeTarget(frame.bytes, limits, &held);
  if (absl::IsInvalidArgument(decoded.status())) {
    return WithDetail(decoded.status(), {"BAD_FRAME", frame.bytes_field, "", ""});
  }
  if (absl::IsResourceExhausted(decoded.status())) {
    return WithDetail(decoded.status(), {"LIMIT_EXCEEDED", frame.bytes_field, "", ""});
  }
  RETURN_IF_ERROR(decoded.status());
  if (frame.point_count != 0 && frame.point_count != static_cast<uint64_t>(held)) {
    return InvalidField(absl::StrCat(frame.header_field, ".point_count"),
                        absl::StrCat(frame.point_count),
                        absl::StrCat("the bytes hold ", held, " points"));
  }
  absl::Status valid = ValidateTarget(*decoded);
  if (valid.ok() && !decoded->has_normals()) valid = EstimateNormals(NormalOptions(), &*decoded);
  if (!valid.ok()) return WithDetail(valid, {"BAD_FRAME", frame.bytes_field, "", ""});
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
