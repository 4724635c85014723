// Files of one format, which FUZZ_FORMAT names: refused, or a valid geometry.
#include <cstring>

#include "client/io/format_readers.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/geometry_seeds.h"

namespace cagefit::testing {
namespace {

absl::StatusOr<client::Geometry> Read(const std::string& format, const std::string& bytes) {
  client::ReadLimits limits;
  limits.max_vertices = limits.max_faces = 100'000;
  if (format == "ply") return client::ReadPly(bytes, limits);
  if (format == "off") return client::ReadOff(bytes, limits);
  if (format == "stl") return client::ReadStl(bytes, limits);
  if (format == "xyz") return client::ReadXyz(bytes, limits);
  if (format == "pcd") return client::ReadPcd(bytes, limits);
  if (format == "drc") return client::ReadDrc(bytes, limits);
  FUZZ_CHECK(format == "obj");
  CreaseTags tags;
  auto geometry = client::ReadObj(bytes, limits, &tags);
  // A control mesh from any file: valid or refused.
  if (geometry.ok()) {
    ControlMesh::Create(geometry->mesh.vertices, geometry->mesh.triangles, tags).IgnoreError();
  }
  return geometry;
}

}  // namespace

std::vector<std::string> FuzzSeeds() { return GeometrySeeds(FUZZ_FORMAT); }

}  // namespace cagefit::testing

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cagefit;
  using namespace cagefit::testing;
  const auto geometry = Read(FUZZ_FORMAT, BytesOf(data, size));
  if (!geometry.ok()) {
    FUZZ_CHECK(absl::IsInvalidArgument(geometry.status()) ||
               absl::IsResourceExhausted(geometry.status()));
    return 0;
  }
  const TriangleMesh& mesh = geometry->mesh;
  FUZZ_CHECK(mesh.vertices.cols() > 0);
  FUZZ_CHECK(mesh.vertices.allFinite());
  FUZZ_CHECK(mesh.triangles.size() == 0 ||
             (mesh.triangles.minCoeff() >= 0 && mesh.triangles.maxCoeff() < mesh.vertices.cols()));
  FUZZ_CHECK(geometry->normals.cols() == 0 || geometry->normals.cols() == mesh.vertices.cols());
  client::ToCloud(*geometry);
  return 0;
}
