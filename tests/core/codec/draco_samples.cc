#include "tests/core/codec/draco_samples.h"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include <cmath>
#include <memory>
#include <utility>

#include "core/codec/draco_codec.h"

namespace cagefit::testing {
namespace {

int Add(draco::GeometryAttribute::Type type, const Eigen::MatrixXf& values,
        draco::PointCloud* cloud) {
  auto attribute = std::make_unique<draco::PointAttribute>();
  attribute->Init(type, static_cast<int8_t>(values.rows()), draco::DT_FLOAT32, false,
                  static_cast<size_t>(values.cols()));
  attribute->buffer()->Write(0, values.data(), sizeof(float) * values.size());
  return cloud->AddAttribute(std::move(attribute));
}

std::string Run(draco::ExpertEncoder* encoder) {
  draco::EncoderBuffer buffer;
  return encoder->EncodeToBuffer(&buffer).ok() ? std::string(buffer.data(), buffer.size()) : "";
}

}  // namespace

TriangleMesh WavyGrid(int n) {
  TriangleMesh mesh;
  mesh.vertices.resize(3, n * n);
  mesh.triangles.resize(3, 2 * (n - 1) * (n - 1));
  int face = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const int v = i * n + j;
      mesh.vertices.col(v) << i, j, std::sin(0.7 * i) * std::cos(0.9 * j);
      if (i + 1 == n || j + 1 == n) continue;
      mesh.triangles.col(face++) << v, v + n, v + 1;
      mesh.triangles.col(face++) << v + 1, v + n, v + n + 1;
    }
  }
  return mesh;
}

std::string EdgebreakerBytes(const TriangleMesh& mesh, const EdgebreakerSample& sample) {
  const Eigen::Index n = mesh.vertices.cols();
  draco::Mesh out;
  out.set_num_points(static_cast<uint32_t>(n));
  out.SetNumFaces(static_cast<size_t>(mesh.triangles.cols()));
  for (Eigen::Index i = 0; i < mesh.triangles.cols(); ++i) {
    draco::Mesh::Face face;
    for (int k = 0; k < 3; ++k) face[k] = draco::PointIndex(mesh.triangles(k, i));
    out.SetFace(draco::FaceIndex(static_cast<uint32_t>(i)), face);
  }
  const int position = Add(draco::GeometryAttribute::POSITION, mesh.vertices.cast<float>(), &out);
  int coordinates = -1, normals = -1;
  if (sample.texture_coordinates) {
    coordinates =
        Add(draco::GeometryAttribute::TEX_COORD, mesh.vertices.topRows(2).cast<float>() / 10, &out);
  }
  if (sample.normals) {
    const Eigen::Vector3f up(0, 0, 1);
    normals = Add(draco::GeometryAttribute::NORMAL, up.replicate(1, n), &out);
  }
  if (sample.metadata) {
    auto metadata = std::make_unique<draco::GeometryMetadata>();
    metadata->AddEntryString("made by", "a test");
    auto child = std::make_unique<draco::Metadata>();
    child->AddEntryInt("answer", 42);
    metadata->AddSubMetadata("child", std::move(child));
    out.AddMetadata(std::move(metadata));
  }
  draco::ExpertEncoder encoder(out);
  encoder.SetSpeedOptions(0, 0);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetAttributeQuantization(position, 14);
  if (coordinates >= 0) {
    encoder.SetAttributeQuantization(coordinates, 12);
    if (!encoder
             .SetAttributePredictionScheme(coordinates, draco::MESH_PREDICTION_TEX_COORDS_PORTABLE)
             .ok()) {
      return "";
    }
  }
  if (normals >= 0) encoder.SetAttributeQuantization(normals, 10);
  return Run(&encoder);
}

std::string SequentialCloudBytes(const Points3f& points, const Points3f& normals) {
  draco::PointCloud cloud;
  cloud.set_num_points(static_cast<uint32_t>(points.cols()));
  Add(draco::GeometryAttribute::POSITION, points, &cloud);
  Add(draco::GeometryAttribute::NORMAL, normals, &cloud);
  draco::ExpertEncoder encoder(cloud);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
  return Run(&encoder);
}

std::vector<NamedBytes> AllDracoSamples() {
  const TriangleMesh grid = WavyGrid(5);
  PointCloud cloud;
  cloud.points = grid.vertices.cast<float>();
  cloud.normals = VertexNormals(grid).cast<float>();
  return {
      {"sequential cloud", SequentialCloudBytes(cloud.points, cloud.normals)},
      {"kd-tree cloud", EncodeDracoCloud(cloud, {}).value_or("")},
      {"sequential mesh", EncodeDracoMesh(grid, {}).value_or("")},
      {"quantised mesh", EncodeDracoMesh(grid, {12, 7}).value_or("")},
      {"edgebreaker", EdgebreakerBytes(grid, {})},
      {"edgebreaker with normals", EdgebreakerBytes(grid, {true, false, false})},
      {"edgebreaker with everything", EdgebreakerBytes(grid, {true, true, true})},
  };
}

}  // namespace cagefit::testing
