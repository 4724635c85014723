// One channel out of the several that a file of a mask may have. Internal to core/codec.
#ifndef CAGEFIT_CORE_CODEC_MASK_CHANNEL_H_
#define CAGEFIT_CORE_CODEC_MASK_CHANNEL_H_

#include <cstdint>
#include <vector>

#include "core/image/image.h"

namespace cagefit {

// Row by row from the top; the channels of a pixel lie side by side: gray, gray and alpha, RGB, or
// RGB and alpha.
struct PixelSamples {
  int width = 0, height = 0;
  int channels = 1;          // 1 to 4
  int bytes_per_sample = 1;  // 1, or 2 with the higher byte first
  std::vector<uint8_t> bytes;
};

// The mask, 1 channel of 0 to 1:
//
//   alpha                           where alpha varies and the colour of what is visible does not
//   0.2126 R + 0.7152 G + 0.0722 B  else, of the values as they are stored; gray stays gray
//
// Visible are the pixels with alpha above 0. Thus a cut-out in one colour is read by its alpha, and
// the alpha that some programs add to every image changes nothing.
Image MaskChannel(const PixelSamples& samples);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_MASK_CHANNEL_H_
