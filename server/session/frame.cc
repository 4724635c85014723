#include "server/session/frame.h"

#include <cstring>
#include <new>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "core/cloud/normals.h"
#include "core/cloud/surface_cloud.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

template <typename Value>
void AppendBytes(const Value& value, std::string* bytes) {
  char raw[sizeof(Value)];
  std::memcpy(raw, &value, sizeof(Value));
  bytes->append(raw, sizeof(Value));
}

// Also of what the bytes do not say: which camera each mask is of, where one ends, and landmarks.
Digest DigestOf(const Frame& frame) {
  const Digest of_bytes = Sha256(frame.bytes);
  if (frame.stated_masks.empty() && frame.landmarks.empty()) return of_bytes;
  std::string all(of_bytes.begin(), of_bytes.end());
  for (const StatedMask& mask : frame.stated_masks) {
    absl::StrAppend(&all, mask.camera.size(), ":", mask.camera, ":", mask.png_bytes, ";");
  }
  for (const Landmark& landmark : frame.landmarks) {
    AppendBytes(landmark.vertex, &all);
    AppendBytes(landmark.at.face, &all);
    for (const double value : {landmark.at.u, landmark.at.v, landmark.position[0],
                               landmark.position[1], landmark.position[2]}) {
      AppendBytes(value, &all);
    }
  }
  return Sha256(all);
}

// The cloud, or the surface of a mesh, which is kept too; `held` is the number of points that the
// bytes hold.
absl::StatusOr<PointCloud> DecodeTarget(absl::string_view bytes, const DecodeLimits& limits,
                                        int64_t* held, std::optional<TriangleMesh>* kept) {
  ASSIGN_OR_RETURN(const DracoInfo info, InspectDraco(bytes));
  if (!info.is_mesh) {
    ASSIGN_OR_RETURN(PointCloud cloud, DecodeDracoCloud(bytes, limits));
    *held = cloud.size();
    return cloud;
  }
  Points3f normals;
  ASSIGN_OR_RETURN(*kept, DecodeDracoMesh(bytes, limits, &normals));
  *held = (*kept)->vertices.cols();
  return SurfaceCloud(**kept, normals);
}

absl::StatusOr<PointCloud> DecodeGeometry(const DecodeLimits& limits, const Frame& frame,
                                          std::optional<TriangleMesh>* mesh) {
  if (frame.point_count > static_cast<uint64_t>(limits.max_points)) {
    return LimitExceeded(absl::StrCat(frame.header_field, ".point_count"), frame.point_count,
                         limits.max_points);
  }
  int64_t held = 0;
  auto decoded = DecodeTarget(frame.geometry(), limits, &held, mesh);
  if (absl::IsInvalidArgument(decoded.status())) {
    return WithDetail(decoded.status(), {"BAD_FRAME", frame.bytes_field, "", ""});
  }
  if (absl::IsResourceExhausted(decoded.status()) && !DetailOf(decoded.status()).has_value()) {
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

absl::StatusOr<PointCloud> Decode(const DecodeLimits& limits, const std::vector<Camera>& cameras,
                                  Frame* frame) {
  const std::string field = absl::StrCat(frame->header_field, ".masks");
  const uint64_t total = frame->bytes.size();
  ASSIGN_OR_RETURN(const uint64_t mask_bytes, MaskBytes(field, frame->stated_masks, total));
  frame->geometry_bytes = total - mask_bytes;
  ASSIGN_OR_RETURN(PointCloud cloud, DecodeGeometry(limits, *frame, &frame->mesh));
  ASSIGN_OR_RETURN(frame->masks,
                   DecodeMasks(field, absl::string_view(frame->bytes).substr(frame->geometry_bytes),
                               frame->stated_masks, cameras));
  return cloud;
}

}  // namespace

void HashFrame(Frame* frame) { frame->digest = DigestOf(*frame); }

void DecodeFrame(const DecodeLimits& limits, const std::vector<Camera>& cameras,
                 const ClockFn& clock, Frame* frame) {
  const double start = clock();
  if (frame->digest == Digest{}) HashFrame(frame);
  try {
    frame->cloud = Decode(limits, cameras, frame);
  } catch (const std::bad_alloc&) {
    frame->cloud = WithDetail(
        absl::ResourceExhaustedError("the server has no memory left to decode this frame"),
        {"LIMIT_EXCEEDED", "memory", "", "", absl::Seconds(1)});
  }
  frame->decode_ms = clock() - start;
}

}  // namespace cagefit::server
