#include "client/io/geometry_file.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "client/io/file_bytes.h"
#include "client/io/format_readers.h"
#include "core/base/status.h"

namespace cagefit::client {
namespace {

constexpr char kReadable[] = ".ply, .obj, .stl, .off, .xyz, .pcd or .drc";

absl::StatusOr<Geometry> ReadBytes(absl::string_view extension, absl::string_view bytes,
                                   const ReadLimits& limits, CreaseTags* tags) {
  if (bytes.empty()) return absl::InvalidArgumentError("the file is empty");
  if (extension == ".ply") return ReadPly(bytes, limits);
  if (extension == ".obj") return ReadObj(bytes, limits, tags);
  if (extension == ".stl") return ReadStl(bytes, limits);
  if (extension == ".off") return ReadOff(bytes, limits);
  if (extension == ".pcd") return ReadPcd(bytes, limits);
  if (extension == ".drc") return ReadDrc(bytes, limits);
  return ReadXyz(bytes, limits);
}

absl::Status Prefixed(const std::string& path, const absl::Status& status) {
  return absl::Status(status.code(), absl::StrCat(path, ": ", status.message()));
}

absl::StatusOr<Geometry> ReadFile(const std::string& path, const ReadLimits& limits,
                                  CreaseTags* tags) {
  const std::string extension = FileExtension(path);
  if (!IsGeometryFile(path)) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": its name ends with \"", extension, "\"; expected ", kReadable));
  }
  ASSIGN_OR_RETURN(const std::string bytes, ReadFileBytes(path, limits.max_file_bytes));
  try {
    auto geometry = ReadBytes(extension, bytes, limits, tags);
    if (!geometry.ok()) return Prefixed(path, geometry.status());
    return geometry;
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(absl::StrCat(path, ": there is no memory left to read it"));
  }
}

// The columns whose normal has a direction, with unit normals.
PointCloud WithUnitNormals(const PointCloud& cloud) {
  PointCloud out;
  out.points.resize(3, cloud.size());
  out.normals.resize(3, cloud.size());
  int64_t kept = 0;
  for (int64_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d normal = cloud.normals.col(i).cast<double>().stableNormalized();
    if (!(normal.squaredNorm() > 0.5)) continue;
    out.points.col(kept) = cloud.points.col(i);
    out.normals.col(kept++) = normal.cast<float>();
  }
  out.points.conservativeResize(3, kept);
  out.normals.conservativeResize(3, kept);
  return out;
}

}  // namespace

std::string FileExtension(const std::string& path) {
  const size_t slash = path.rfind('/'), dot = path.rfind('.');
  if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return "";
  return absl::AsciiStrToLower(path.substr(dot));
}

bool IsGeometryFile(const std::string& path) {
  static constexpr absl::string_view kExtensions[] = {".ply", ".obj", ".stl", ".off",
                                                      ".xyz", ".pcd", ".drc"};
  const std::string extension = FileExtension(path);
  return std::find(std::begin(kExtensions), std::end(kExtensions), extension) !=
         std::end(kExtensions);
}

absl::StatusOr<Geometry> ReadGeometry(const std::string& path, const ReadLimits& limits) {
  CreaseTags tags;
  ASSIGN_OR_RETURN(Geometry geometry, ReadFile(path, limits, &tags));
  geometry.tags = std::move(tags);
  return geometry;
}

PointCloud ToCloud(const Geometry& geometry) {
  if (geometry.normals.cols() == 0 && !geometry.is_cloud()) return CloudFromMesh(geometry.mesh);
  PointCloud cloud;
  cloud.points = geometry.mesh.vertices.cast<float>();
  cloud.normals = geometry.normals;
  return cloud.has_normals() ? WithUnitNormals(cloud) : cloud;
}

absl::StatusOr<ControlMesh> ReadControlMesh(const std::string& path) {
  CreaseTags tags;
  ASSIGN_OR_RETURN(Geometry geometry, ReadFile(path, ReadLimits(), &tags));
  if (geometry.is_cloud()) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": it has no faces; a control mesh needs them"));
  }
  auto mesh = ControlMesh::Create(std::move(geometry.mesh.vertices),
                                  std::move(geometry.mesh.triangles), std::move(tags));
  if (!mesh.ok()) return Prefixed(path, mesh.status());
  return mesh;
}

}  // namespace cagefit::client
