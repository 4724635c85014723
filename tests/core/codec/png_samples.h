// PNG files of every kind, written without libpng: an oracle for the decoder.
#ifndef CAGEFIT_TESTS_CORE_CODEC_PNG_SAMPLES_H_
#define CAGEFIT_TESTS_CORE_CODEC_PNG_SAMPLES_H_

#include <cstdint>
#include <string>
#include <vector>

namespace cagefit::testing {

enum PngColor { kGray = 0, kRgb = 2, kPalette = 3, kGrayAlpha = 4, kRgba = 6 };

struct PngSample {
  uint32_t width = 1, height = 1;
  int bits = 8;
  PngColor color = kGray;
  bool interlaced = false;
  std::vector<int> samples;  // row by row from the top, channels side by side
  std::string palette;       // R, G, B of each entry
  std::string transparency;  // of tRNS as the file has it
};

std::string PngBytes(const PngSample& sample);

// Only the signature and a header that claims a size.
std::string PngHeader(uint32_t width, uint32_t height);

// With the checksum of each chunk made good, as far as the chunks can be followed.
std::string WithGoodChecksums(std::string bytes);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_CODEC_PNG_SAMPLES_H_
