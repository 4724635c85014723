#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"
#include "core/codec/draco_convert.h"
#include "core/codec/draco_guard.h"

namespace cagefit {
namespace {

constexpr auto kPosition = draco::GeometryAttribute::POSITION;
constexpr auto kNormal = draco::GeometryAttribute::NORMAL;

// Shorter than any unit vector after quantisation to 8 bits, longer than a zero vector after it.
constexpr float kShortestNormal = 0.01f;
// The largest component of a unit vector, with room for rounding.
constexpr float kLongestNormal = 1.0001f;

// Scales normals to length 1 and moves the points that have one to the front.
void KeepPointsWithNormals(PointCloud* cloud) {
  Eigen::Index kept = 0;
  for (Eigen::Index i = 0; i < cloud->points.cols(); ++i) {
    const Eigen::Vector3f normal = cloud->normals.col(i);
    const float length = normal.norm();
    if (!(length >= kShortestNormal)) continue;
    cloud->points.col(kept) = cloud->points.col(i);
    cloud->normals.col(kept++) = normal / length;
  }
  if (kept == cloud->points.cols()) return;
  cloud->points.conservativeResize(3, kept);
  cloud->normals.conservativeResize(3, kept);
}

absl::Status CheckRange(const char* field, int value, int min, int max) {
  if (value >= min && value <= max) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %d, must be %d to %d", field, value, min, max));
}

absl::Status CheckEncodable(const PointCloud& cloud, const DracoCloudOptions& options) {
  RETURN_IF_ERROR(CheckRange("position_bits", options.position_bits, 1, 30));
  RETURN_IF_ERROR(CheckRange("normal_bits", options.normal_bits, 2, 30));
  RETURN_IF_ERROR(CheckRange("speed", options.speed, 0, 10));
  if (cloud.size() == 0) return absl::InvalidArgumentError("points: none to encode");
  if (cloud.has_normals() && cloud.normals.cols() != cloud.points.cols()) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "normals: %d for %d points", static_cast<int64_t>(cloud.normals.cols()), cloud.size()));
  }
  if (cloud.has_normals() && !(cloud.normals.cwiseAbs().maxCoeff() <= kLongestNormal)) {
    return absl::InvalidArgumentError("normals: not unit vectors");
  }
  const Box& box = options.box;
  for (Eigen::Index i = 0; i < cloud.points.cols(); ++i) {
    const Eigen::Vector3d p = cloud.points.col(i).cast<double>();
    const bool inside = box.empty() || ((p.array() >= box.min.array()).all() &&
                                        (p.array() <= box.max.array()).all());
    if (p.allFinite() && inside) continue;
    return absl::InvalidArgumentError(
        absl::StrFormat("points: %d = (%g, %g, %g) is not finite or outside the quantisation box",
                        static_cast<int64_t>(i), p.x(), p.y(), p.z()));
  }
  return absl::OkStatus();
}

// Draco quantises in a cube at `origin`. Rounding to float may not leave a point of the box
// outside.
struct QuantizationCube {
  Eigen::Vector3f origin;
  float range;
};

QuantizationCube CubeAround(const Box& box) {
  const float infinity = std::numeric_limits<float>::infinity();
  QuantizationCube cube;
  cube.origin = box.min.cast<float>();
  for (int axis = 0; axis < 3; ++axis) {
    float& x = cube.origin[axis];
    if (x > box.min[axis]) x = std::nextafter(x, -infinity);
  }
  const double range = (box.max - cube.origin.cast<double>()).maxCoeff();
  // One grid step of a point-sized cloud must still be positive.
  cube.range = std::nextafter(std::max(static_cast<float>(range), 1e-30f), infinity);
  return cube;
}

}  // namespace

absl::StatusOr<PointCloud> DecodeDracoCloud(absl::string_view bytes, const DecodeLimits& limits) {
  ASSIGN_OR_RETURN(const GuardedGeometry geometry, DecodeGuarded(bytes, limits));
  const draco::PointAttribute* normals = geometry.points->GetNamedAttribute(kNormal);
  if (geometry.mesh != nullptr && normals == nullptr) {
    ASSIGN_OR_RETURN(const TriangleMesh mesh, ToTriangleMesh(geometry));
    return CloudFromMesh(mesh);
  }
  PointCloud cloud;
  ASSIGN_OR_RETURN(const draco::PointAttribute* positions, PositionAttribute(*geometry.points));
  ASSIGN_OR_RETURN(cloud.points, ReadVectors3f(*geometry.points, *positions, "position"));
  if (normals != nullptr) {
    ASSIGN_OR_RETURN(cloud.normals, ReadVectors3f(*geometry.points, *normals, "normal"));
    KeepPointsWithNormals(&cloud);
  }
  return cloud;
}

absl::StatusOr<std::string> EncodeDracoCloud(const PointCloud& cloud,
                                             const DracoCloudOptions& options) {
  RETURN_IF_ERROR(CheckEncodable(cloud, options));
  draco::PointCloud points;
  points.set_num_points(static_cast<uint32_t>(cloud.size()));
  const int position_id = AddAttribute(kPosition, cloud.points, &points);
  const int normal_id = cloud.has_normals() ? AddAttribute(kNormal, cloud.normals, &points) : -1;

  draco::ExpertEncoder encoder(points);
  encoder.SetSpeedOptions(options.speed, options.speed);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_KD_TREE_ENCODING);
  const QuantizationCube cube =
      CubeAround(options.box.empty() ? BoundingBox(cloud.points) : options.box);
  encoder.SetAttributeExplicitQuantization(position_id, options.position_bits, 3,
                                           cube.origin.data(), cube.range);
  if (cloud.has_normals()) {
    // The cube of all unit vectors, so that this grid does not move between frames either.
    const float origin[3] = {-1, -1, -1};
    encoder.SetAttributeExplicitQuantization(normal_id, options.normal_bits, 3, origin, 2);
  }
  return EncodeToString(&encoder);
}

}  // namespace cagefit
