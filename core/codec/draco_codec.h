// Clouds and meshes as Draco bytes. The only part of the project that knows Draco.
//
// Input is hostile: the header is checked and counts are held against limits before memory is
// taken, every face index is checked after decoding, and points that are not finite are refused.
#ifndef CAGEFIT_CORE_CODEC_DRACO_CODEC_H_
#define CAGEFIT_CORE_CODEC_DRACO_CODEC_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/cloud/point_cloud.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

struct DecodeLimits {
  int64_t max_encoded_bytes = 64 << 20;
  int64_t max_points = 4'000'000;
  int64_t max_faces = 8'000'000;
  int64_t max_decoded_bytes = int64_t{512} << 20;  // of all attributes and faces together
};

enum class DracoGeometry { kPointCloud, kMesh };

// What the bytes say of themselves, read without decoding.
struct DracoInfo {
  DracoGeometry geometry = DracoGeometry::kPointCloud;
  int version_major = 0, version_minor = 0;
  bool has_metadata = false;
};

// INVALID_ARGUMENT when the bytes are not Draco or of an unknown kind, RESOURCE_EXHAUSTED naming
// limit and value.
absl::StatusOr<DracoInfo> InspectDraco(absl::string_view bytes, const DecodeLimits& limits);

// Cloud with normals where the bytes have them. A mesh gives its vertices, with angle-weighted
// normals where it has none of its own. INVALID_ARGUMENT says what is wrong; RESOURCE_EXHAUSTED
// names limit and value.
absl::StatusOr<PointCloud> DecodeDracoCloud(absl::string_view bytes, const DecodeLimits& limits);

// INVALID_ARGUMENT for a point cloud.
absl::StatusOr<TriangleMesh> DecodeDracoMesh(absl::string_view bytes, const DecodeLimits& limits);

struct DracoCloudOptions {
  int position_bits = 14;  // 1 to 30
  int normal_bits = 10;    // 2 to 30
  int speed = 7;           // 0 (small) to 10 (fast)
  Box box;  // quantisation box, the same for all frames of a capture; empty: the cloud's own
};
absl::StatusOr<std::string> EncodeDracoCloud(const PointCloud& cloud,
                                             const DracoCloudOptions& options);

struct DracoMeshOptions {
  int position_bits = 0;  // 1 to 30; 0 keeps 32-bit floats
  int speed = 7;
};
absl::StatusOr<std::string> EncodeDracoMesh(const TriangleMesh& mesh,
                                            const DracoMeshOptions& options);

// A sequential int32 attribute of 3 components: control vertex deltas on request. At most
// max_vertices on decoding.
absl::StatusOr<std::string> EncodeDracoIntegers(
    const Eigen::Matrix<int32_t, 3, Eigen::Dynamic>& values);
absl::StatusOr<Eigen::Matrix<int32_t, 3, Eigen::Dynamic>> DecodeDracoIntegers(
    absl::string_view bytes, int64_t max_vertices);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_DRACO_CODEC_H_
