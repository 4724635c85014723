#include <limits>

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"
#include "core/codec/draco_convert.h"
#include "core/codec/draco_guard.h"

namespace cagefit {
namespace {

// Draco's entropy coder takes a table of one integer per grid step.
constexpr int kMaxCompressedBits = 20;

absl::Status CheckEncodable(const TriangleMesh& mesh, const DracoMeshOptions& options) {
  if (options.position_bits < 0 || options.position_bits > 30) {
    return absl::InvalidArgumentError(
        absl::StrFormat("position_bits is %d, must be 0 to 30", options.position_bits));
  }
  if (options.speed < 0 || options.speed > 10) {
    return absl::InvalidArgumentError(
        absl::StrFormat("speed is %d, must be 0 to 10", options.speed));
  }
  if (mesh.triangles.cols() == 0) return absl::InvalidArgumentError("triangles: none to encode");
  if (mesh.triangles.minCoeff() < 0 || mesh.triangles.maxCoeff() >= mesh.vertices.cols()) {
    return absl::InvalidArgumentError(
        absl::StrFormat("triangles: indices %d to %d for %d vertices", mesh.triangles.minCoeff(),
                        mesh.triangles.maxCoeff(), static_cast<int64_t>(mesh.vertices.cols())));
  }
  if (!(mesh.vertices.cwiseAbs().maxCoeff() <= std::numeric_limits<float>::max())) {
    return absl::InvalidArgumentError("vertices: not finite as 32-bit floats");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<TriangleMesh> ToTriangleMesh(const GuardedGeometry& geometry) {
  TriangleMesh out;
  ASSIGN_OR_RETURN(const draco::PointAttribute* positions, PositionAttribute(*geometry.points));
  ASSIGN_OR_RETURN(out.vertices, ReadVectors3d(*geometry.points, *positions, "position"));
  if (geometry.mesh == nullptr) return out;
  out.triangles.resize(3, geometry.mesh->num_faces());
  for (draco::FaceIndex i(0); i < geometry.mesh->num_faces(); ++i) {
    const draco::Mesh::Face& face = geometry.mesh->face(i);
    out.triangles.col(i.value()) << static_cast<int32_t>(face[0].value()),
        static_cast<int32_t>(face[1].value()), static_cast<int32_t>(face[2].value());
  }
  return out;
}

absl::StatusOr<TriangleMesh> DecodeDracoMesh(absl::string_view bytes, const DecodeLimits& limits,
                                             Points3f* normals) {
  ASSIGN_OR_RETURN(const GuardedGeometry geometry, DecodeGuarded(bytes, limits));
  ASSIGN_OR_RETURN(TriangleMesh mesh, ToTriangleMesh(geometry));
  if (normals == nullptr) return mesh;
  normals->resize(3, 0);
  const draco::PointAttribute* attribute =
      geometry.points->GetNamedAttribute(draco::GeometryAttribute::NORMAL);
  if (attribute != nullptr) {
    ASSIGN_OR_RETURN(*normals, ReadVectors3f(*geometry.points, *attribute, "normal"));
  }
  return mesh;
}

absl::StatusOr<std::string> EncodeDracoMesh(const TriangleMesh& mesh,
                                            const DracoMeshOptions& options) {
  RETURN_IF_ERROR(CheckEncodable(mesh, options));
  draco::Mesh out;
  out.set_num_points(static_cast<uint32_t>(mesh.vertices.cols()));
  out.SetNumFaces(static_cast<size_t>(mesh.triangles.cols()));
  for (Eigen::Index i = 0; i < mesh.triangles.cols(); ++i) {
    draco::Mesh::Face face;
    for (int k = 0; k < 3; ++k) {
      face[k] = draco::PointIndex(static_cast<uint32_t>(mesh.triangles(k, i)));
    }
    out.SetFace(draco::FaceIndex(static_cast<uint32_t>(i)), face);
  }
  const int position_id =
      AddAttribute(draco::GeometryAttribute::POSITION, Points3f(mesh.vertices.cast<float>()), &out);

  draco::ExpertEncoder encoder(out);
  encoder.SetSpeedOptions(options.speed, options.speed);
  // Edgebreaker would be smaller, but it changes the order of vertices and triangles. Compressed
  // indices would, too, be smaller, but above a certain ratio Draco refuses to decode them.
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  if (options.position_bits > 0) {
    encoder.SetAttributeQuantization(position_id, options.position_bits);
    if (options.position_bits > kMaxCompressedBits) {
      encoder.SetUseBuiltInAttributeCompression(false);
    }
  }
  return EncodeToString(&encoder);
}

}  // namespace cagefit
