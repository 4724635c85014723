#include "core/image/pixel_buckets.h"

#include <cmath>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 8192;

int NodeCount(int pixels, int per_pixel) { return pixels > 0 ? per_pixel * (pixels - 1) + 1 : 0; }

}  // namespace

void PixelBuckets::Build(const std::vector<float>& u, const std::vector<float>& v,
                         const PixelWindow& window, int cells_per_pixel) {
  width_ = NodeCount(window.width, cells_per_pixel);
  height_ = NodeCount(window.height, cells_per_pixel);
  const auto count = static_cast<int64_t>(u.size());
  const int64_t cells = static_cast<int64_t>(width_) * height_;
  cell_.resize(count);
  ParallelFor(count, kGrain, [&](int64_t begin, int64_t end) {
    const auto scale = static_cast<float>(cells_per_pixel);
    const float left = static_cast<float>(window.x) * scale - 0.5f;
    const float top = static_cast<float>(window.y) * scale - 0.5f;
    const auto width = static_cast<float>(width_), height = static_cast<float>(height_);
    for (int64_t i = begin; i < end; ++i) {
      const float x = scale * u[i] - left, y = scale * v[i] - top;
      const bool within = x >= 0 && y >= 0 && x < width && y < height;
      cell_[i] = within ? static_cast<int32_t>(y) * width_ + static_cast<int32_t>(x) : -1;
    }
  });
  // Counting sort; the shift by two leaves the cells' beginnings in place at the end.
  begin_.assign(cells + 2, 0);
  for (const int32_t c : cell_) {
    if (c >= 0) ++begin_[c + 2];
  }
  for (int64_t c = 2; c <= cells + 1; ++c) begin_[c] += begin_[c - 1];
  source_.resize(begin_[cells + 1]);
  for (int64_t i = 0; i < count; ++i) {
    if (cell_[i] >= 0) source_[begin_[cell_[i] + 1]++] = static_cast<int32_t>(i);
  }
}

}  // namespace cagefit
