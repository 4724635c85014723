#include <draco/compression/expert_encode.h>

#include <memory>

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"

namespace cagefit {

namespace {

absl::Status CheckOption(const char* field, int value, int least, int most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s is %d; it must be from %d to %d", field, value, least, most));
}

// Adds `values` (3 x N, contiguous) as an attribute in point order and returns its id.
template <typename Scalar>
int AddAttribute(draco::GeometryAttribute::Type kind, draco::DataType type,
                 const Eigen::Matrix<Scalar, 3, Eigen::Dynamic>& values, draco::PointCloud* cloud) {
  draco::GeometryAttribute description;
  description.Init(kind, nullptr, 3, type, false, 3 * sizeof(Scalar), 0);
  const int id = cloud->AddAttribute(description, true, static_cast<uint32_t>(values.cols()));
  cloud->attribute(id)->buffer()->Write(0, values.data(), values.size() * sizeof(Scalar));
  return id;
}

absl::StatusOr<std::string> Finish(draco::ExpertEncoder* encoder) {
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder->EncodeToBuffer(&buffer);
  if (!status.ok()) {
    return absl::InternalError(absl::StrFormat("draco: encoding failed: %s", status.error_msg()));
  }
  return std::string(buffer.data(), buffer.size());
}

}  // namespace

absl::StatusOr<std::string> EncodeDracoCloud(const PointCloud& cloud,
                                             const DracoCloudOptions& options) {
  RETURN_IF_ERROR(CheckOption("position_bits", options.position_bits, 1, 30));
  RETURN_IF_ERROR(CheckOption("normal_bits", options.normal_bits, 2, 30));
  RETURN_IF_ERROR(CheckOption("speed", options.speed, 0, 10));
  if (cloud.size() == 0) return absl::InvalidArgumentError("draco: the cloud is empty");
  const Box own = BoundingBox(cloud.points);
  const Box& box = options.box.empty() ? own : options.box;
  if ((own.min.array() < box.min.array()).any() || (own.max.array() > box.max.array()).any()) {
    return absl::InvalidArgumentError("draco: points lie outside the quantisation box");
  }

  draco::PointCloud out;
  out.set_num_points(static_cast<uint32_t>(cloud.size()));
  const int position =
      AddAttribute(draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, cloud.points, &out);
  int normal = -1;
  if (cloud.has_normals()) {
    normal = AddAttribute(draco::GeometryAttribute::NORMAL, draco::DT_FLOAT32, cloud.normals, &out);
  }
  draco::ExpertEncoder encoder(out);
  encoder.SetSpeedOptions(options.speed, options.speed);
  // Named, because speed 10 would silently mean sequential coding, and an unquantised attribute
  // would, too.
  encoder.SetEncodingMethod(draco::POINT_CLOUD_KD_TREE_ENCODING);
  const Eigen::Vector3f origin = box.min.cast<float>();
  const float range = std::max(1e-20f, static_cast<float>(box.size().maxCoeff()));
  encoder.SetAttributeExplicitQuantization(position, options.position_bits, 3, origin.data(),
                                           range);
  if (normal >= 0) encoder.SetAttributeQuantization(normal, options.normal_bits);
  return Finish(&encoder);
}

absl::StatusOr<std::string> EncodeDracoMesh(const TriangleMesh& mesh,
                                            const DracoMeshOptions& options) {
  RETURN_IF_ERROR(CheckOption("position_bits", options.position_bits, 0, 30));
  RETURN_IF_ERROR(CheckOption("speed", options.speed, 0, 10));
  if (mesh.vertices.cols() == 0 || mesh.triangles.cols() == 0) {
    return absl::InvalidArgumentError("draco: the mesh is empty");
  }
  draco::Mesh out;
  out.set_num_points(static_cast<uint32_t>(mesh.vertices.cols()));
  const int position = AddAttribute<float>(draco::GeometryAttribute::POSITION, draco::DT_FLOAT32,
                                           mesh.vertices.cast<float>(), &out);
  out.SetNumFaces(mesh.triangles.cols());
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    draco::Mesh::Face face;
    for (int c = 0; c < 3; ++c) face[c] = draco::PointIndex(mesh.triangles(c, f));
    out.SetFace(draco::FaceIndex(static_cast<uint32_t>(f)), face);
  }
  draco::ExpertEncoder encoder(out);
  encoder.SetSpeedOptions(options.speed, options.speed);
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  if (options.position_bits > 0) encoder.SetAttributeQuantization(position, options.position_bits);
  return Finish(&encoder);
}

absl::StatusOr<std::string> EncodeDracoIntegers(const GridPoints& values) {
  if (values.cols() == 0) return absl::InvalidArgumentError("draco: no values");
  draco::PointCloud out;
  out.set_num_points(static_cast<uint32_t>(values.cols()));
  AddAttribute(draco::GeometryAttribute::GENERIC, draco::DT_INT32, values, &out);
  draco::ExpertEncoder encoder(out);
  // Never the kd-tree: it would change the order.
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  encoder.SetSpeedOptions(5, 5);
  return Finish(&encoder);
}

}  // namespace cagefit
