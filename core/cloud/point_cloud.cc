#include "core/cloud/point_cloud.h"

#include "absl/strings/str_format.h"

namespace cagefit {

absl::Status ValidateTarget(const PointCloud& cloud) {
  if (cloud.size() < kMinTargetPoints) {
    return absl::InvalidArgumentError(
        absl::StrFormat("points: %d; a target needs at least %d", cloud.size(), kMinTargetPoints));
  }
  if (cloud.has_normals() && cloud.normals.cols() != cloud.size()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("normals: %d for %d points", cloud.normals.cols(), cloud.size()));
  }
  // One pass decides; only a bad cloud pays for finding the culprit.
  if (cloud.points.allFinite() && cloud.normals.allFinite()) return absl::OkStatus();
  for (int64_t i = 0; i < cloud.size(); ++i) {
    const auto p = cloud.points.col(i);
    if (!p.allFinite()) {
      return absl::InvalidArgumentError(
          absl::StrFormat("point %d: (%g, %g, %g) is not finite", i, p[0], p[1], p[2]));
    }
    if (cloud.has_normals() && !cloud.normals.col(i).allFinite()) {
      return absl::InvalidArgumentError(absl::StrFormat("normal %d is not finite", i));
    }
  }
  return absl::InternalError("target: not finite");
}

PointCloud CloudFromMesh(const TriangleMesh& mesh) {
  const Points3d normals = VertexNormals(mesh);
  PointCloud cloud;
  cloud.points.resize(3, normals.cols());
  cloud.normals.resize(3, normals.cols());
  int64_t kept = 0;
  for (int64_t v = 0; v < normals.cols(); ++v) {
    if (normals.col(v).isZero(0)) continue;
    cloud.points.col(kept) = mesh.vertices.col(v).cast<float>();
    cloud.normals.col(kept++) = normals.col(v).cast<float>();
  }
  cloud.points.conservativeResize(3, kept);
  cloud.normals.conservativeResize(3, kept);
  return cloud;
}

}  // namespace cagefit
