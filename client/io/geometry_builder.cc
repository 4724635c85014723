#include "client/io/geometry_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

bool IsFinite(const double* point) {
  return std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
}

}  // namespace

absl::Status GeometryBuilder::CheckCounts(uint64_t vertices, uint64_t polygons) const {
  if (vertices > static_cast<uint64_t>(limits_.max_vertices)) {
    return absl::ResourceExhaustedError(
        absl::StrCat(vertices, " vertices; the limit is ", limits_.max_vertices));
  }
  if (polygons > static_cast<uint64_t>(limits_.max_faces)) {
    return absl::ResourceExhaustedError(
        absl::StrCat(polygons, " faces; the limit is ", limits_.max_faces));
  }
  return absl::OkStatus();
}

absl::Status GeometryBuilder::AddVertex(double x, double y, double z) {
  RETURN_IF_ERROR(CheckCounts(vertex_count() + 1, 0));
  vertices_.insert(vertices_.end(), {x, y, z});
  return absl::OkStatus();
}

void GeometryBuilder::AddNormal(double x, double y, double z) {
  const bool finite = std::isfinite(x) && std::isfinite(y) && std::isfinite(z);
  for (const double value : {x, y, z}) normals_.push_back(finite ? static_cast<float>(value) : 0);
}

absl::Status GeometryBuilder::AddPolygon(absl::Span<const int64_t> corners) {
  for (size_t k = 2; k < corners.size(); ++k) {
    corners_.insert(corners_.end(), {corners[0], corners[k - 1], corners[k]});
    polygon_of_triangle_.push_back(polygons_);
  }
  ++polygons_;
  return CheckCounts(0, std::max<uint64_t>(polygons_, polygon_of_triangle_.size()));
}

absl::Status GeometryBuilder::CheckCorners() const {
  for (size_t k = 0; k < corners_.size(); ++k) {
    if (corners_[k] >= 0 && corners_[k] < vertex_count()) continue;
    return absl::InvalidArgumentError(absl::StrCat("face ", polygon_of_triangle_[k / 3],
                                                   " names vertex ", corners_[k], " (from 0) of ",
                                                   vertex_count()));
  }
  return absl::OkStatus();
}

absl::Status GeometryBuilder::CheckFinite() const {
  for (int64_t v = 0; v < vertex_count(); ++v) {
    const double* point = &vertices_[3 * v];
    if (IsFinite(point)) continue;
    return absl::InvalidArgumentError(absl::StrCat(
        "vertex ", v, " (from 0) is not finite: ", point[0], " ", point[1], " ", point[2]));
  }
  return absl::OkStatus();
}

void GeometryBuilder::DropNanPoints() {
  size_t kept = 0;
  for (size_t at = 0; at < vertices_.size(); at += 3) {
    const double* point = &vertices_[at];
    if (std::isnan(point[0]) || std::isnan(point[1]) || std::isnan(point[2])) continue;
    std::copy_n(point, 3, &vertices_[kept]);
    if (!normals_.empty()) std::copy_n(&normals_[at], 3, &normals_[kept]);
    kept += 3;
  }
  vertices_.resize(kept);
  if (!normals_.empty()) normals_.resize(kept);
}

absl::StatusOr<Geometry> GeometryBuilder::Finish(NanPoints nan_points) {
  if (vertices_.empty()) return absl::InvalidArgumentError("no vertices in it");
  if (normals_.size() != vertices_.size()) normals_.clear();  // of some vertices only: of none
  if (nan_points == NanPoints::kDropFromClouds && corners_.empty()) DropNanPoints();
  if (vertices_.empty()) return absl::InvalidArgumentError("no vertex is a number");
  RETURN_IF_ERROR(CheckFinite());
  RETURN_IF_ERROR(CheckCorners());
  if (vertex_count() > std::numeric_limits<int32_t>::max()) {
    return absl::ResourceExhaustedError("more vertices than 32-bit indices reach");
  }
  Geometry geometry;
  geometry.polygons = polygons_;
  geometry.mesh.vertices = Eigen::Map<const Points3d>(vertices_.data(), 3, vertex_count());
  geometry.mesh.triangles.resize(3, static_cast<int64_t>(corners_.size()) / 3);
  std::transform(corners_.begin(), corners_.end(), geometry.mesh.triangles.data(),
                 [](int64_t v) { return static_cast<int32_t>(v); });
  if (!normals_.empty()) {
    geometry.normals = Eigen::Map<const Points3f>(normals_.data(), 3, vertex_count());
  }
  return geometry;
}

}  // namespace cagefit::client
