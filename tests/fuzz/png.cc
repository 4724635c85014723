// PNG files: refused, or an image within the limits whose values are from 0 to 1.
#include "core/codec/png.h"

#include "tests/core/codec/png_samples.h"
#include "tests/fuzz/fuzz_target.h"

namespace cagefit::testing {

std::vector<std::string> FuzzSeeds() {
  const auto sample = [](int bits, PngColor color, bool interlaced, std::vector<int> samples) {
    PngSample png;
    png.width = 2;
    png.height = 2;
    png.bits = bits;
    png.color = color;
    png.interlaced = interlaced;
    png.samples = std::move(samples);
    if (color == kPalette) png.palette = std::string("\x00\x80\xff\xff\x01\x02", 6);
    return PngBytes(png);
  };
  return {sample(1, kGray, false, {0, 1, 1, 0}),
          sample(16, kGray, true, {0, 65535, 7, 8}),
          sample(8, kPalette, false, {0, 1, 1, 0}),
          sample(8, kGrayAlpha, false, {0, 255, 7, 8, 0, 255, 7, 8}),
          sample(8, kRgb, true, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}),
          sample(8, kRgba, false, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16})};
}

}  // namespace cagefit::testing

// As it is, and with checksums that let a mutation past the first check.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cagefit;
  using namespace cagefit::testing;
  const std::string given = BytesOf(data, size);
  for (const std::string& bytes : {given, WithGoodChecksums(given)}) {
    const auto image = DecodePng(bytes, {64, 64, 64 * 64});
    if (!image.ok()) {
      FUZZ_CHECK(absl::IsInvalidArgument(image.status()) ||
                 absl::IsResourceExhausted(image.status()));
      continue;
    }
    FUZZ_CHECK(image->width >= 1 && image->width <= 64);
    FUZZ_CHECK(image->height >= 1 && image->height <= 64);
    for (const float value : image->values) FUZZ_CHECK(value >= 0 && value <= 1);
  }
  return 0;
}
