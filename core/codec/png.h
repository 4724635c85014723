// Masks and images as PNG bytes. The only part of the project that knows libpng.
//
// Values are stored as they are, 0 to 1 as 0 to 2^bits - 1: no gamma, no colour profile.
#ifndef CAGEFIT_CORE_CODEC_PNG_H_
#define CAGEFIT_CORE_CODEC_PNG_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "core/image/image.h"

namespace cagefit {

struct PngLimits {
  int max_width = 16384, max_height = 16384;  // pixels
  int64_t max_pixels = int64_t{64} << 20;     // decoding takes up to 12 bytes for each
};

// A mask: 1 channel, 0 to 1, from gray or colour of 1 to 16 bits, with or without palette, alpha
// and interlacing. With alpha or colour it is the channel that MaskChannel
// (core/codec/mask_channel.h) takes: the alpha of a cut-out in one colour, else the luminance.
//
// The input is hostile: what the header claims is held against the limits, and against what so many
// bytes can hold at best, before memory is taken. INVALID_ARGUMENT says what is wrong with the
// bytes, RESOURCE_EXHAUSTED names limit and value.
absl::StatusOr<Image> DecodePng(absl::string_view bytes, const PngLimits& limits);

// Gray (1 channel) or RGB (3) of 8 or 16 bits. Values are clamped to 0 to 1 and rounded; NaN counts
// as 0. INVALID_ARGUMENT for other channels or bits and for an image without pixels.
absl::StatusOr<std::string> EncodePng(const Image& image, int bits);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_PNG_H_
