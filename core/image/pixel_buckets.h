// Points of an image sorted by the cell that they lie in.
#ifndef CAGEFIT_CORE_IMAGE_PIXEL_BUCKETS_H_
#define CAGEFIT_CORE_IMAGE_PIXEL_BUCKETS_H_

#include <cstdint>
#include <vector>

namespace cagefit {

// A rectangle of pixels; its corner may be negative.
struct PixelWindow {
  int x = 0, y = 0, width = 0, height = 0;
};

// The cells are squares around the nodes of a grid with `cells_per_pixel` nodes a pixel, from the
// centre of the window's first pixel to that of its last. Rows follow each other, so the points of
// neighbouring cells of a row are one run. Their order depends on the points alone. Buffers keep
// their capacity.
class PixelBuckets {
 public:
  // Sorts the points (u[i], v[i]), in pixels with centres at integers. Points outside the cells, or
  // that are not numbers, are left out.
  void Build(const std::vector<float>& u, const std::vector<float>& v, const PixelWindow& window,
             int cells_per_pixel);

  int width() const { return width_; }
  int height() const { return height_; }
  int32_t size() const { return static_cast<int32_t>(source_.size()); }
  // Index of the first sorted point of cell (x, y); x may be width(): the end of the row.
  int32_t begin(int x, int y) const { return begin_[static_cast<int64_t>(y) * width_ + x]; }
  // Index among the given points of a sorted point.
  int32_t source(int32_t k) const { return source_[k]; }

 private:
  int width_ = 0, height_ = 0;
  std::vector<int32_t> begin_, cell_, source_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_PIXEL_BUCKETS_H_
