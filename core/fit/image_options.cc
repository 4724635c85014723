#include "core/fit/image_options.h"

#include "core/base/check_range.h"
#include "core/base/status.h"

namespace cagefit {

absl::Status ImageOptions::Validate() const {
  RETURN_IF_ERROR(CheckRange("image.weight", weight.value_or(0), 0, 1e9));
  RETURN_IF_ERROR(CheckRange("image.depth_weight", depth_weight, 0, 1e6));
  RETURN_IF_ERROR(CheckRange("image.normal_weight", normal_weight, 0, 1e6));
  RETURN_IF_ERROR(CheckRange("image.size", size, 64, 2048));
  RETURN_IF_ERROR(CheckRange("image.view_count", view_count, 1, 200));
  RETURN_IF_ERROR(CheckRange("image.views_per_iteration", views_per_iteration, 0, 200));
  RETURN_IF_ERROR(CheckRange("image.calibration_error", calibration_error, 0, 100));
  RETURN_IF_ERROR(CheckRange("image.sigma", sigma, 1e-8, 1));
  RETURN_IF_ERROR(CheckRange("image.blur_radius", blur_radius, 0, 1));
  return CheckRange("image.faces_per_pixel", faces_per_pixel, 1, 1000);
}

}  // namespace cagefit
