// Draco bytes as clouds and as meshes: what the header claims is held against limits, and what is
// decoded is valid.
#include "core/codec/draco_codec.h"
#include "tests/core/codec/draco_samples.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/frames.h"

namespace cagefit::testing {
namespace {

DecodeLimits SmallLimits() {
  DecodeLimits limits;
  limits.max_points = 20'000;
  limits.max_faces = 40'000;
  limits.max_decoded_bytes = 16 << 20;
  limits.allow_metadata = true;
  return limits;
}

void CheckError(const absl::Status& status) {
  FUZZ_CHECK(absl::IsInvalidArgument(status) || absl::IsResourceExhausted(status));
}

void CheckCloud(const std::string& bytes) {
  const auto cloud = DecodeDracoCloud(bytes, SmallLimits());
  if (!cloud.ok()) return CheckError(cloud.status());
  FUZZ_CHECK(cloud->size() <= SmallLimits().max_points);
  FUZZ_CHECK(cloud->points.allFinite());
  FUZZ_CHECK(!cloud->has_normals() || cloud->normals.cols() == cloud->size());
  FUZZ_CHECK(cloud->normals.allFinite());
}

void CheckMesh(const std::string& bytes) {
  Points3f normals;
  const auto mesh = DecodeDracoMesh(bytes, SmallLimits(), &normals);
  if (!mesh.ok()) return CheckError(mesh.status());
  FUZZ_CHECK(mesh->vertices.allFinite());
  FUZZ_CHECK(mesh->triangles.size() == 0 || (mesh->triangles.minCoeff() >= 0 &&
                                             mesh->triangles.maxCoeff() < mesh->vertices.cols()));
  FUZZ_CHECK(normals.cols() == 0 || normals.cols() == mesh->vertices.cols());
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  std::vector<std::string> seeds = {FrameBytes(MovingCloud(0, 30))};
  for (const NamedBytes& sample : AllDracoSamples()) seeds.push_back(sample.bytes);
  return seeds;
}

}  // namespace cagefit::testing

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cagefit;
  using namespace cagefit::testing;
  const std::string bytes = BytesOf(data, size);
  CheckCloud(bytes);
  CheckMesh(bytes);
  const auto stripped = StripDracoMetadata(bytes);
  if (stripped.ok()) FUZZ_CHECK(!InspectDraco(*stripped)->has_metadata);
  return 0;
}
