#include "core/codec/mask_channel.h"

#include <algorithm>

namespace cagefit {
namespace {

constexpr double kRed = 0.2126, kGreen = 0.7152, kBlue = 0.0722;  // ITU-R BT.709

// Samples of one pixel after the other as whole numbers.
class Pixels {
 public:
  explicit Pixels(const PixelSamples& samples)
      : samples_(samples), has_alpha_(samples.channels % 2 == 0) {}

  int64_t count() const { return static_cast<int64_t>(samples_.width) * samples_.height; }
  int colors() const { return samples_.channels - (has_alpha_ ? 1 : 0); }
  bool has_alpha() const { return has_alpha_; }
  int max() const { return samples_.bytes_per_sample == 1 ? 255 : 65535; }

  int Value(int64_t pixel, int channel) const {
    const int64_t k = pixel * samples_.channels + channel;
    if (samples_.bytes_per_sample == 1) return samples_.bytes[k];
    return samples_.bytes[2 * k] << 8 | samples_.bytes[2 * k + 1];
  }
  int Alpha(int64_t pixel) const { return Value(pixel, samples_.channels - 1); }

  bool SameColor(int64_t a, int64_t b) const {
    for (int c = 0; c < colors(); ++c) {
      if (Value(a, c) != Value(b, c)) return false;
    }
    return true;
  }

 private:
  const PixelSamples& samples_;
  bool has_alpha_;
};

bool IsCutOut(const Pixels& pixels) {
  if (!pixels.has_alpha()) return false;
  bool alpha_varies = false;
  int64_t visible = -1;  // the first
  for (int64_t i = 0; i < pixels.count(); ++i) {
    alpha_varies = alpha_varies || pixels.Alpha(i) != pixels.Alpha(0);
    if (pixels.Alpha(i) == 0) continue;
    if (visible < 0) visible = i;
    if (!pixels.SameColor(i, visible)) return false;
  }
  return alpha_varies;
}

}  // namespace

Image MaskChannel(const PixelSamples& samples) {
  const Pixels pixels(samples);
  const bool cut_out = IsCutOut(pixels);
  Image mask(samples.width, samples.height);
  for (int64_t i = 0; i < pixels.count(); ++i) {
    double value = 0;
    if (cut_out) {
      value = pixels.Alpha(i);
    } else if (pixels.colors() == 1) {
      value = pixels.Value(i, 0);
    } else {
      value = kRed * pixels.Value(i, 0) + kGreen * pixels.Value(i, 1) + kBlue * pixels.Value(i, 2);
    }
    mask.values[i] = static_cast<float>(std::min(value / pixels.max(), 1.0));
  }
  return mask;
}

}  // namespace cagefit
