#include "client/synth/rig.h"

#include <cmath>

#include "absl/strings/str_format.h"
#include "core/base/check_range.h"
#include "core/base/random.h"
#include "core/base/status.h"
#include "core/image/mesh_renderer.h"
#include "core/image/views.h"

namespace cagefit::client {
namespace {

constexpr int kTimes = 24;  // of one period, at which the shape's extent is looked at

}  // namespace

absl::Status RigOptions::Validate() const {
  RETURN_IF_ERROR(CheckRange("cameras", cameras, 0, 64));
  RETURN_IF_ERROR(CheckRange("mask_size", size, 64, 2048));
  RETURN_IF_ERROR(CheckRange("masks_every", every, 1, 100'000));
  return CheckRange("camera_error", error, 0, 100);
}

Rig::Rig(const SynthShape& shape, const RigOptions& options, uint64_t seed)
    : every_(options.every) {
  if (options.cameras == 0) return;
  Box all = BoundingBox(shape.Vertices(0));
  for (int k = 1; k < kTimes; ++k) {
    const Box box = BoundingBox(shape.Vertices(static_cast<double>(k) / kTimes));
    all.min = all.min.cwiseMin(box.min);
    all.max = all.max.cwiseMax(box.max);
  }
  cameras_ =
      SphereViews(options.cameras, 0.5 * (all.min + all.max), 0.5 * all.diagonal(), options.size);
  for (size_t k = 0; k < cameras_.size(); ++k) cameras_[k].name = absl::StrFormat("camera_%02d", k);
  calibrated_ = cameras_;
  Random random(seed);
  for (Camera& camera : calibrated_) {
    const double direction = random.Uniform(0, 2 * M_PI);
    camera.cx += options.error * std::cos(direction);
    camera.cy += options.error * std::sin(direction);
  }
}

Image Rig::Mask(const SynthShape& shape, double time, size_t k) const {
  Image mask = RenderMesh({shape.Vertices(time), shape.rest().triangles}, cameras_[k]).silhouette;
  for (float& value : mask.values) value = value >= 0.5F ? 1 : 0;
  return mask;
}

}  // namespace cagefit::client
