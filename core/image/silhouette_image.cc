#include "core/image/silhouette_image.h"

#include <cmath>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 4096;
constexpr double kTail = 1e-5;

}  // namespace

double SilhouetteReach(double sigma_ndc, double half_side) {
  return half_side * std::sqrt(sigma_ndc * std::log(1 / kTail - 1));
}

Image SilhouetteFromOutline(const OutlineDistance& distance, const Image& inside, double sigma_ndc,
                            double half_side) {
  Image image(distance.width, distance.height);
  const double scale = 1 / (half_side * half_side * sigma_ndc);
  ParallelFor(image.pixel_count(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t p = begin; p < end; ++p) {
      const bool is_inside = inside.values[p] >= 0.5f;
      if (distance.segment[p] < 0) {
        image.values[p] = is_inside ? 1.0f : 0.0f;
        continue;
      }
      const double d = distance.distance[p];
      const double exponent = (is_inside ? -scale : scale) * d * d;
      image.values[p] = static_cast<float>(1 / (1 + std::exp(exponent)));
    }
  });
  return image;
}

}  // namespace cagefit
