// Images as arrays of floats.
#ifndef CAGEFIT_CORE_IMAGE_IMAGE_H_
#define CAGEFIT_CORE_IMAGE_IMAGE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cagefit {

// Row by row from the top; the channels of a pixel lie side by side.
struct Image {
  Image() = default;
  Image(int width, int height, int channels = 1, float value = 0)
      : width(width),
        height(height),
        channels(channels),
        values(static_cast<size_t>(width) * height * channels, value) {}

  bool empty() const { return values.empty(); }
  int64_t pixel_count() const { return static_cast<int64_t>(width) * height; }
  float* at(int x, int y) { return &values[(static_cast<size_t>(y) * width + x) * channels]; }
  const float* at(int x, int y) const {
    return &values[(static_cast<size_t>(y) * width + x) * channels];
  }

  int width = 0, height = 0, channels = 1;
  std::vector<float> values;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_IMAGE_H_
