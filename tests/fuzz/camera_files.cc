// Camera files, JSON and COLMAP's: refused, or valid cameras, which as JSON read back to the same.
#include "absl/strings/str_cat.h"
#include "client/io/camera_readers.h"
#include "tests/client/io/camera_samples.h"
#include "tests/fuzz/fuzz_target.h"

namespace cagefit::testing {
namespace {

constexpr char kBetween[] = "----\n";  // COLMAP's two files in one

void CheckCameras(const absl::StatusOr<std::vector<Camera>>& cameras) {
  if (!cameras.ok()) {
    FUZZ_CHECK(absl::IsInvalidArgument(cameras.status()));
    return;
  }
  for (const Camera& camera : *cameras) FUZZ_CHECK(camera.Validate().ok());
}

void CheckJson(const std::string& bytes) {
  const auto cameras = client::ReadCamerasJson(bytes);
  CheckCameras(cameras);
  if (!cameras.ok()) return;
  const auto json = client::CamerasToJson(*cameras);
  FUZZ_CHECK(json.ok());
  const auto again = client::ReadCamerasJson(*json);
  FUZZ_CHECK(again.ok());
  FUZZ_CHECK(client::CamerasToJson(*again) == json);
}

void CheckColmap(const std::string& bytes) {
  const size_t between = bytes.find(kBetween);
  if (between == std::string::npos) return;
  const auto intrinsics = client::ReadColmapCameras(bytes.substr(0, between));
  if (!intrinsics.ok()) {
    FUZZ_CHECK(absl::IsInvalidArgument(intrinsics.status()));
    return;
  }
  CheckCameras(client::ReadColmapImages(bytes.substr(between + sizeof(kBetween) - 1), *intrinsics));
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  return {client::kCamerasJson,
          absl::StrCat(client::kColmapCameras, kBetween, client::kColmapImages)};
}

}  // namespace cagefit::testing

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cagefit::testing;
  const std::string bytes = BytesOf(data, size);
  CheckJson(bytes);
  CheckColmap(bytes);
  return 0;
}
