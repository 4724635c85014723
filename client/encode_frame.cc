#include "client/encode_frame.h"

#include "absl/strings/str_cat.h"
#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"

namespace cagefit::client {
namespace {

constexpr int64_t kMaxFileBytes = int64_t{1} << 30;
constexpr int kNormalBits = 12;

absl::StatusOr<std::string> Encode(const Geometry& geometry, int position_bits) {
  if (!geometry.is_cloud()) return EncodeDracoMesh(geometry.mesh, DracoMeshOptions());
  DracoCloudOptions options;
  options.position_bits = position_bits;
  options.normal_bits = kNormalBits;
  return EncodeDracoCloud(ToCloud(geometry), options);
}

}  // namespace

absl::StatusOr<std::string> EncodeFrame(const std::string& path, int position_bits) {
  if (FileExtension(path) == ".drc") {
    ASSIGN_OR_RETURN(std::string bytes, ReadFileBytes(path, kMaxFileBytes));
    const auto info = InspectDraco(bytes);
    // What cannot be read is for the server to judge: it answers this frame and goes on.
    if (!info.ok() || !info->has_metadata) return bytes;
    auto stripped = StripDracoMetadata(bytes);
    return stripped.ok() ? stripped : bytes;
  }
  ASSIGN_OR_RETURN(const Geometry geometry, ReadGeometry(path));
  auto bytes = Encode(geometry, position_bits);
  if (bytes.ok()) return bytes;
  return absl::Status(bytes.status().code(), absl::StrCat(path, ": ", bytes.status().message()));
}

}  // namespace cagefit::client
