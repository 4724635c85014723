#include <Eigen/Geometry>
#include <cstring>
#include <string>

#include "absl/strings/str_cat.h"
#include "client/io/file_bytes.h"
#include "client/io/geometry_file.h"
#include "client/io/number_text.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"

namespace cagefit::client {
namespace {

template <typename Derived>
void AppendRow(const Eigen::MatrixBase<Derived>& values, std::string* text) {
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    if (k > 0) text->push_back(' ');
    AppendNumber(values(k), text);
  }
}

template <typename Value>
void AppendBinary(const Value& value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

void AppendRows(const char* name, const Points3d& points, std::string* text) {
  for (Eigen::Index k = 0; k < points.cols(); ++k) {
    text->append(name);
    AppendRow(points.col(k), text);
    text->push_back('\n');
  }
}

std::string ObjText(const TriangleMesh& mesh, const CornerNormals& normals) {
  std::string text;
  AppendRows("v ", mesh.vertices, &text);
  AppendRows("vn ", normals.values, &text);
  for (Eigen::Index f = 0; f < mesh.triangles.cols(); ++f) {
    text.push_back('f');
    for (int c = 0; c < 3; ++c) {
      text.push_back(' ');
      AppendNumber(mesh.triangles(c, f) + 1, &text);
      if (normals.values.cols() == 0) continue;
      text.append("//");
      AppendNumber(normals.indices(c, f) + 1, &text);
    }
    text.push_back('\n');
  }
  return text;
}

std::string OffText(const TriangleMesh& mesh) {
  std::string text =
      absl::StrCat("OFF\n", mesh.vertices.cols(), " ", mesh.triangles.cols(), " 0\n");
  AppendRows("", mesh.vertices, &text);
  for (Eigen::Index f = 0; f < mesh.triangles.cols(); ++f) {
    text.append("3 ");
    AppendRow(mesh.triangles.col(f), &text);
    text.push_back('\n');
  }
  return text;
}

Points3d VertexMeans(const TriangleMesh& mesh, const CornerNormals& normals) {
  Points3d means = Points3d::Zero(3, mesh.vertices.cols());
  for (Eigen::Index h = 0; h < mesh.triangles.size(); ++h) {
    means.col(mesh.triangles.data()[h]) += normals.values.col(normals.indices.data()[h]);
  }
  means.colwise().normalize();
  return means;
}

std::string PlyMeshBytes(const TriangleMesh& mesh, const CornerNormals& normals) {
  const bool has_normals = normals.values.cols() > 0;
  std::string bytes = absl::StrCat(
      "ply\nformat binary_little_endian 1.0\nelement vertex ", mesh.vertices.cols(),
      "\nproperty double x\nproperty double y\nproperty double z\n",
      has_normals ? "property double nx\nproperty double ny\nproperty double nz\n" : "",
      "element face ", mesh.triangles.cols(),
      "\nproperty list uchar int vertex_indices\nend_header\n");
  const Points3d of_vertices = has_normals ? VertexMeans(mesh, normals) : Points3d();
  for (Eigen::Index v = 0; v < mesh.vertices.cols(); ++v) {
    for (int axis = 0; axis < 3; ++axis) AppendBinary(mesh.vertices(axis, v), &bytes);
    for (int axis = 0; axis < 3 && has_normals; ++axis) {
      AppendBinary(of_vertices(axis, v), &bytes);
    }
  }
  for (Eigen::Index f = 0; f < mesh.triangles.cols(); ++f) {
    bytes.push_back(3);
    for (int c = 0; c < 3; ++c) AppendBinary(mesh.triangles(c, f), &bytes);
  }
  return bytes;
}

std::string StlBytes(const TriangleMesh& mesh) {
  std::string bytes(80, '\0');
  AppendBinary(static_cast<uint32_t>(mesh.triangles.cols()), &bytes);
  for (Eigen::Index f = 0; f < mesh.triangles.cols(); ++f) {
    const Eigen::Vector3d a = mesh.vertices.col(mesh.triangles(0, f));
    const Eigen::Vector3d b = mesh.vertices.col(mesh.triangles(1, f));
    const Eigen::Vector3d c = mesh.vertices.col(mesh.triangles(2, f));
    const Eigen::Vector3d normal = (b - a).cross(c - a).stableNormalized();
    for (const Eigen::Vector3d& vector : {normal, a, b, c}) {
      const Eigen::Vector3f single = vector.cast<float>();
      for (int axis = 0; axis < 3; ++axis) AppendBinary(single[axis], &bytes);
    }
    AppendBinary(uint16_t{0}, &bytes);
  }
  return bytes;
}

std::string PlyCloudBytes(const PointCloud& cloud) {
  std::string bytes =
      absl::StrCat("ply\nformat binary_little_endian 1.0\nelement vertex ", cloud.size(),
                   "\nproperty float x\nproperty float y\nproperty float z\n");
  if (cloud.has_normals()) {
    bytes.append("property float nx\nproperty float ny\nproperty float nz\n");
  }
  bytes.append("end_header\n");
  for (int64_t i = 0; i < cloud.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) AppendBinary(cloud.points(axis, i), &bytes);
    for (int axis = 0; axis < 3 && cloud.has_normals(); ++axis) {
      AppendBinary(cloud.normals(axis, i), &bytes);
    }
  }
  return bytes;
}

std::string XyzText(const PointCloud& cloud) {
  std::string text;
  for (int64_t i = 0; i < cloud.size(); ++i) {
    AppendRow(cloud.points.col(i), &text);
    if (cloud.has_normals()) {
      text.push_back(' ');
      AppendRow(cloud.normals.col(i), &text);
    }
    text.push_back('\n');
  }
  return text;
}

absl::Status BadName(const std::string& path, absl::string_view expected) {
  return absl::InvalidArgumentError(absl::StrCat(path, ": its name ends with \"",
                                                 FileExtension(path), "\"; expected ", expected));
}

}  // namespace

absl::Status WriteMesh(const std::string& path, const TriangleMesh& mesh,
                       const CornerNormals& normals) {
  const std::string extension = FileExtension(path);
  if (extension == ".obj") return WriteFileBytes(path, ObjText(mesh, normals));
  if (extension == ".off") return WriteFileBytes(path, OffText(mesh));
  if (extension == ".ply") return WriteFileBytes(path, PlyMeshBytes(mesh, normals));
  if (extension == ".stl") return WriteFileBytes(path, StlBytes(mesh));
  if (extension == ".drc") {
    ASSIGN_OR_RETURN(const std::string bytes, EncodeDracoMesh(mesh, {}));
    return WriteFileBytes(path, bytes);
  }
  return BadName(path, ".obj, .ply, .off, .stl or .drc");
}

absl::Status WriteControlMesh(const std::string& path, const ControlMesh& mesh) {
  const TriangleMesh triangles = {mesh.vertices(), mesh.triangles()};
  if (FileExtension(path) != ".obj") {
    if (mesh.tags().edges.empty() && mesh.tags().corners.empty()) return WriteMesh(path, triangles);
    return BadName(path, ".obj, which alone keeps creases and corners");
  }
  std::string text;
  for (const auto& [a, b] : mesh.tags().edges) {
    absl::StrAppend(&text, "# cagefit crease ", a + 1, " ", b + 1, "\n");
  }
  for (const int32_t corner : mesh.tags().corners) {
    absl::StrAppend(&text, "# cagefit corner ", corner + 1, "\n");
  }
  return WriteFileBytes(path, text + ObjText(triangles, {}));
}

absl::Status WriteCloud(const std::string& path, const PointCloud& cloud) {
  const std::string extension = FileExtension(path);
  if (extension == ".ply") return WriteFileBytes(path, PlyCloudBytes(cloud));
  if (extension == ".xyz") return WriteFileBytes(path, XyzText(cloud));
  if (extension == ".drc") {
    ASSIGN_OR_RETURN(const std::string bytes, EncodeDracoCloud(cloud, {}));
    return WriteFileBytes(path, bytes);
  }
  return BadName(path, ".ply, .xyz or .drc");
}

}  // namespace cagefit::client
