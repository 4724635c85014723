#include <cstring>

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"
#include "core/codec/draco_guard.h"

namespace cagefit {

namespace {

// The values of a three-component attribute, one column a point.
template <typename Scalar>
absl::Status CopyAttribute(const draco::PointCloud& cloud, draco::GeometryAttribute::Type type,
                           Eigen::Matrix<Scalar, 3, Eigen::Dynamic>* out) {
  const draco::PointAttribute* attribute = cloud.GetNamedAttribute(type);
  const int64_t count = cloud.num_points();
  if (attribute == nullptr || attribute->num_components() != 3) {
    return absl::InvalidArgumentError(
        absl::StrFormat("draco: no %s attribute of three components",
                        draco::GeometryAttribute::TypeToString(type)));
  }
  out->resize(3, count);
  const bool plain = std::is_same_v<Scalar, float> && attribute->is_mapping_identity() &&
                     attribute->data_type() == draco::DT_FLOAT32 &&
                     attribute->byte_stride() == 3 * sizeof(float) &&
                     static_cast<int64_t>(attribute->size()) >= count;
  if (plain) {
    std::memcpy(out->data(), attribute->GetAddress(draco::AttributeValueIndex(0)),
                3 * sizeof(float) * count);
    return absl::OkStatus();
  }
  for (int64_t i = 0; i < count; ++i) {
    const draco::AttributeValueIndex value =
        attribute->mapped_index(draco::PointIndex(static_cast<uint32_t>(i)));
    if (value.value() >= attribute->size() ||
        !attribute->ConvertValue<Scalar>(value, 3, out->col(i).data())) {
      return absl::InvalidArgumentError(absl::StrFormat("draco: point %d has no value", i));
    }
  }
  return absl::OkStatus();
}

template <typename Matrix>
absl::Status CheckFinite(const char* what, const Matrix& values) {
  if (values.allFinite()) return absl::OkStatus();
  for (int64_t i = 0; i < values.cols(); ++i) {
    const auto v = values.col(i);
    if (!v.allFinite()) {
      return absl::InvalidArgumentError(
          absl::StrFormat("draco: %s %d is (%g, %g, %g), not finite", what, i, v[0], v[1], v[2]));
    }
  }
  return absl::OkStatus();
}

absl::Status CopyNormals(const draco::PointCloud& cloud, Points3f* normals) {
  const draco::PointAttribute* attribute =
      cloud.GetNamedAttribute(draco::GeometryAttribute::NORMAL);
  if (attribute == nullptr || attribute->num_components() != 3) {
    normals->resize(3, 0);
    return absl::OkStatus();
  }
  RETURN_IF_ERROR(CopyAttribute(cloud, draco::GeometryAttribute::NORMAL, normals));
  return CheckFinite("normal", *normals);
}

Triangles CopyFaces(const draco::Mesh& mesh) {
  Triangles triangles(3, mesh.num_faces());
  for (uint32_t f = 0; f < mesh.num_faces(); ++f) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
    for (int c = 0; c < 3; ++c) triangles(c, f) = static_cast<int32_t>(face[c].value());
  }
  return triangles;
}

}  // namespace

absl::StatusOr<PointCloud> DecodeDracoCloud(absl::string_view bytes, const DecodeLimits& limits) {
  ASSIGN_OR_RETURN(const DecodedDraco decoded, GuardedDecode(bytes, limits));
  PointCloud cloud;
  RETURN_IF_ERROR(CopyAttribute(*decoded.cloud, draco::GeometryAttribute::POSITION, &cloud.points));
  RETURN_IF_ERROR(CheckFinite("point", cloud.points));
  RETURN_IF_ERROR(CopyNormals(*decoded.cloud, &cloud.normals));
  if (decoded.mesh == nullptr || cloud.has_normals()) return cloud;
  return CloudFromMesh({cloud.points.cast<double>(), CopyFaces(*decoded.mesh)});
}

absl::StatusOr<TriangleMesh> DecodeDracoMesh(absl::string_view bytes, const DecodeLimits& limits,
                                             Points3f* normals) {
  ASSIGN_OR_RETURN(const DecodedDraco decoded, GuardedDecode(bytes, limits));
  TriangleMesh mesh;
  RETURN_IF_ERROR(
      CopyAttribute(*decoded.cloud, draco::GeometryAttribute::POSITION, &mesh.vertices));
  RETURN_IF_ERROR(CheckFinite("point", mesh.vertices));
  if (normals != nullptr) RETURN_IF_ERROR(CopyNormals(*decoded.cloud, normals));
  mesh.triangles.resize(3, 0);
  if (decoded.mesh != nullptr) mesh.triangles = CopyFaces(*decoded.mesh);
  return mesh;
}

absl::StatusOr<GridPoints> DecodeDracoIntegers(absl::string_view bytes, int64_t max_vertices) {
  DecodeLimits limits;
  limits.max_points = max_vertices;
  ASSIGN_OR_RETURN(const DecodedDraco decoded, GuardedDecode(bytes, limits));
  const draco::PointAttribute* attribute =
      decoded.cloud->GetNamedAttribute(draco::GeometryAttribute::GENERIC);
  if (attribute == nullptr || attribute->num_components() != 3 ||
      attribute->data_type() != draco::DT_INT32) {
    return absl::InvalidArgumentError("draco: no int32 attribute of three components");
  }
  GridPoints values(3, decoded.cloud->num_points());
  for (int64_t i = 0; i < values.cols(); ++i) {
    attribute->GetMappedValue(draco::PointIndex(static_cast<uint32_t>(i)), values.col(i).data());
  }
  return values;
}

}  // namespace cagefit
