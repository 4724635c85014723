// How far each pixel is from an outline.
#ifndef CAGEFIT_CORE_IMAGE_OUTLINE_DISTANCE_H_
#define CAGEFIT_CORE_IMAGE_OUTLINE_DISTANCE_H_

#include <cstdint>
#include <vector>

#include "core/image/outline.h"

namespace cagefit {

// Row by row from the top. Buffers keep their capacity from call to call.
struct OutlineDistance {
  int width = 0, height = 0;
  std::vector<double> distance;  // pixels, to the nearest segment; infinity beyond the reach
  std::vector<int32_t> segment;  // its index, the lowest of equally near ones; -1 beyond the reach

  // Scratch: the segments that reach into each strip of rows, in order of their index.
  std::vector<int32_t> strip_begin, strip_segments;
};

// Distances from the pixel centres of a width x height image to the segments of `outline`, as far
// as `reach` >= 0 pixels. Segments may leave the image, lie outside it or have zero length; those
// that are not finite, or longer than 1e150, reach no pixel. Work is in proportion to the pixels
// within reach. The result is the same to the bit for any number of threads.
void MeasureOutline(const Outline& outline, int width, int height, double reach,
                    OutlineDistance* out);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_OUTLINE_DISTANCE_H_
