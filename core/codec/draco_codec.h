// Clouds and meshes as Draco bytes. The only part of the project that knows Draco.
//
// Input is hostile: whatever the bytes claim is held against limits before memory is taken, every
// index is checked after decoding, and points that are not finite are refused. Errors of decoding:
// INVALID_ARGUMENT says what is wrong with the bytes, RESOURCE_EXHAUSTED names limit and value.
#ifndef CAGEFIT_CORE_CODEC_DRACO_CODEC_H_
#define CAGEFIT_CORE_CODEC_DRACO_CODEC_H_

#include <cstdint>
#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/cloud/point_cloud.h"
#include "core/codec/vertex_delta.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

struct DecodeLimits {
  int64_t max_points = 4'000'000;
  int64_t max_faces = 8'000'000;
  int64_t max_decoded_bytes = int64_t{512} << 20;  // attributes, faces and the decoder's own tables
  // Asked before the decoder takes so many bytes more; an error ends the decoding. May be empty.
  std::function<absl::Status(int64_t bytes)> reserve;
  // Metadata is never needed here: a service refuses it, a program that reads files skips it.
  bool allow_metadata = false;
};

// What the bytes say of themselves, read without decoding.
struct DracoInfo {
  bool is_mesh = false;
  bool has_metadata = false;
};

// INVALID_ARGUMENT when the bytes are not Draco or of a kind or version that is not read:
// bitstreams 1.0 (written by Draco 0.9) to 2.3, of kd-tree clouds 2.3 only.
absl::StatusOr<DracoInfo> InspectDraco(absl::string_view bytes);

// The same geometry without metadata: what a client sends to a service that refuses metadata.
absl::StatusOr<std::string> StripDracoMetadata(absl::string_view bytes);

// Cloud with unit normals where the bytes have normals; points whose normal has no direction are
// left out. A mesh gives its vertices: with its own normals, or angle-weighted ones, in which case
// vertices without one are left out.
absl::StatusOr<PointCloud> DecodeDracoCloud(absl::string_view bytes, const DecodeLimits& limits);

// A mesh, or a cloud as a mesh without triangles; no vertex is left out. Per-vertex normals as the
// bytes have them (3 x N or 3 x 0) when `normals` is not null.
absl::StatusOr<TriangleMesh> DecodeDracoMesh(absl::string_view bytes, const DecodeLimits& limits,
                                             Points3f* normals = nullptr);

struct DracoCloudOptions {
  int position_bits = 14;  // 1 to 30
  int normal_bits = 10;    // 2 to 30
  int speed = 7;           // 0 (small) to 10 (fast)
  Box box;  // quantisation box, the same for all frames of a capture; empty: the cloud's own
};

// kd-tree coding: points change their order. INVALID_ARGUMENT naming field and value for an option
// out of range, an empty cloud, normals that are not unit vectors, and a point that is not finite
// or lies outside the box.
absl::StatusOr<std::string> EncodeDracoCloud(const PointCloud& cloud,
                                             const DracoCloudOptions& options);

struct DracoMeshOptions {
  int position_bits = 0;  // 1 to 30; 0 keeps 32-bit floats
  int speed = 7;          // 0 (small) to 10 (fast)
};

// Sequential coding: vertices and triangles keep their order, so that meshes of a sequence
// correspond. INVALID_ARGUMENT for an option out of range or a mesh that is empty or not valid.
absl::StatusOr<std::string> EncodeDracoMesh(const TriangleMesh& mesh,
                                            const DracoMeshOptions& options);

// Control vertex deltas on request: one sequential int32 attribute of three components, kept in
// order and to the bit. INVALID_ARGUMENT for no values.
absl::StatusOr<std::string> EncodeDracoIntegers(const GridPoints& values);
absl::StatusOr<GridPoints> DecodeDracoIntegers(absl::string_view bytes, int64_t max_vertices);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_DRACO_CODEC_H_
