// A frame's bytes on their way to a fit: geometry, normals that are estimated, masks.
#include "server/session/frame.h"

#include <cstring>

#include "core/codec/png.h"
#include "tests/core/codec/draco_samples.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/frames.h"
#include "tests/support/masks.h"

namespace cagefit::testing {
namespace {

// The first byte says how many of the last bytes are the mask of the camera.
std::string WithMask(const std::string& geometry, const std::string& png) {
  return static_cast<char>(png.size()) + geometry + png;
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  const std::string png = MaskPng(4, 3);
  PointCloud bare = MovingCloud(0, 60);
  bare.normals.resize(3, 0);
  std::vector<std::string> seeds = {WithMask(FrameBytes(bare), ""),
                                    WithMask(FrameBytes(MovingCloud(0, 60)), png)};
  for (const NamedBytes& sample : AllDracoSamples()) seeds.push_back(WithMask(sample.bytes, png));
  return seeds;
}

}  // namespace cagefit::testing

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cagefit;
  using namespace cagefit::testing;
  static const std::vector<Camera> cameras = {SmallCamera("left")};
  if (size == 0) return 0;
  server::Frame frame;
  frame.bytes = BytesOf(data + 1, size - 1);
  if (data[0] != 0) frame.stated_masks = {{"left", data[0]}};
  DecodeLimits limits;
  limits.max_points = 250;  // every path, and five times the executions of 2,000
  limits.max_faces = 500;
  limits.max_decoded_bytes = 4 << 20;
  server::DecodeFrame(
      limits, cameras, [] { return 0.0; }, &frame);
  if (!frame.cloud.ok()) {
    FUZZ_CHECK(absl::IsInvalidArgument(frame.cloud.status()) ||
               absl::IsResourceExhausted(frame.cloud.status()));
    return 0;
  }
  FUZZ_CHECK(ValidateTarget(*frame.cloud).ok());
  FUZZ_CHECK(frame.cloud->has_normals());
  FUZZ_CHECK(frame.masks.size() == cameras.size());
  FUZZ_CHECK(data[0] == 0 || (frame.masks[0].width == 4 && frame.masks[0].height == 3));
  return 0;
}
