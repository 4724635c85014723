// What one frame becomes before a fit: its points in unit coordinates without outliers, the index
// of their distance field, and the settings that follow from both.
#ifndef CAGEFIT_CORE_FIT_FRAME_TARGET_H_
#define CAGEFIT_CORE_FIT_FRAME_TARGET_H_

#include "absl/status/status.h"
#include "core/cloud/point_cloud.h"
#include "core/cloud/target_index.h"
#include "core/fit/fit_options.h"
#include "core/fit/frame_images.h"
#include "core/fit/normalization.h"
#include "core/fit/objective.h"

namespace cagefit {

// Buffers keep their capacity from frame to frame. Not movable: the index refers to the cloud.
class FrameTarget {
 public:
  FrameTarget() = default;
  FrameTarget(const FrameTarget&) = delete;

  // Takes `user` (validated, with normals; user units) in. Where no radius is set, h is the larger
  // of radius_factor times the spacing and kRadiusPerNoise times the noise. INVALID_ARGUMENT when
  // fewer than kMinTargetPoints points are left.
  // `source`: what the frame has beside the points. INVALID_ARGUMENT as FrameImages says.
  absl::Status Build(const PointCloud& user, const Normalization& normalization,
                     const FitOptions& options, int64_t control_vertices,
                     const FrameSource& source = {});

  const ObjectiveTarget& objective_target() const { return target_; }
  const TargetIndex& index() const { return index_; }
  const PointCloud& cloud() const { return cloud_; }  // unit coordinates, cleaned
  double noise() const { return noise_; }             // standard deviation, unit coordinates
  int64_t outliers() const { return outliers_; }      // points that were left out

  // alpha where the options set none: kArapWeightPerVertex times the control vertices, and with
  // noise as much more as keeps the surface from following it.
  double ArapWeight(const FitOptions& options, int64_t control_vertices) const;

 private:
  absl::Status Index(const FitOptions& options);
  absl::Status Clean(const FitOptions& options);
  void DrawCovered(int64_t count);
  void PlaceLandmarks(const FrameSource& source, const Normalization& normalization);
  void TraceBoundary(const FrameSource& source, const Normalization& normalization);

  PointCloud cloud_, covered_;
  FrameImages images_;
  std::vector<Landmark> landmarks_;
  BoundaryCurve boundary_;
  TargetIndex index_;
  ObjectiveTarget target_;
  double scale_ = 1, noise_ = 0;
  int64_t outliers_ = 0;
};

inline constexpr double kRadiusPerNoise = 4;

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_FRAME_TARGET_H_
