#include "core/fit/frame_target.h"

#include <algorithm>
#include <vector>

#include "core/base/parallel.h"
#include "core/base/status.h"
#include "core/cloud/noise.h"
#include "core/cloud/outliers.h"
#include "core/cloud/repair_normals.h"

namespace cagefit {

namespace {

// Default far radius as a multiple of the radius h: far enough for the field to stay smooth around
// the cloud, near enough that the rim of an open surface cannot wander.
constexpr double kFarRadiusPerRadius = 3;
constexpr double kKernelScalePerNoise = 2;
// A kernel narrower than this share of the spacing would reject the surface itself.
constexpr double kLeastKernelScale = 0.1;
// Few control vertices need no fewer points each: theirs is the same surface.
constexpr int64_t kLeastCoveragePoints = 16000;
// alpha grows by the square of the noise over this length, in unit coordinates.
constexpr double kNoiseOfDoubleWeight = 1e-3;

void ToUnit(const Normalization& normalization, const PointCloud& user, PointCloud* unit) {
  unit->points.resize(3, user.size());
  ParallelFor(user.size(), 16384, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      unit->points.col(i) =
          ((user.points.col(i).cast<double>() - normalization.center) * normalization.scale)
              .cast<float>();
    }
  });
  unit->normals = user.normals;
}

}  // namespace

absl::Status FrameTarget::Build(const PointCloud& user, const Normalization& normalization,
                                const FitOptions& options, int64_t control_vertices,
                                const FrameSource& source) {
  ToUnit(normalization, user, &cloud_);
  scale_ = normalization.scale;
  noise_ = 0;
  RETURN_IF_ERROR(Index(options));
  RETURN_IF_ERROR(Clean(options));
  noise_ = EstimateNoise(index_.grid()).sigma;
  if (kRadiusPerNoise * noise_ > index_.radius()) RETURN_IF_ERROR(Index(options));

  const DistanceOptions& distance = options.distance;
  target_.index = &index_;
  target_.field = distance.field;
  target_.far_radius = distance.far_radius > 0 ? distance.far_radius * scale_
                                               : kFarRadiusPerRadius * index_.radius();
  const double kernel_scale =
      std::max(kKernelScalePerNoise * noise_, kLeastKernelScale * index_.spacing());
  target_.kernel = {distance.kernel,
                    distance.kernel_scale > 0 ? distance.kernel_scale * scale_ : kernel_scale};
  target_.coverage_weight = options.coverage.weight;
  target_.covered = nullptr;
  if (options.coverage.weight > 0) {
    DrawCovered(
        std::max(kLeastCoveragePoints, options.coverage.points_per_vertex * control_vertices));
    target_.covered = &covered_;
  }
  target_.distance_weight = distance.weight;
  ImageOptions image = options.image;
  if (distance.weight == 0) image.calibration_error = 0;  // nothing else says where the surface is
  RETURN_IF_ERROR(images_.Build(source, cloud_, index_.spacing(), normalization, image));
  const double beta =
      options.image.weight.value_or(kImageWeightPerVertex * static_cast<double>(control_vertices));
  target_.images = &images_.targets();
  target_.image_weights = {beta, beta * options.image.depth_weight,
                           beta * options.image.normal_weight};
  target_.frame = source.frame;
  target_.landmark_weight = options.landmarks.weight;
  PlaceLandmarks(source, normalization);
  target_.boundary_weight = options.boundary.weight;
  target_.boundary = nullptr;
  if (options.boundary.weight > 0) TraceBoundary(source, normalization);
  return absl::OkStatus();
}

absl::Status FrameTarget::Index(const FitOptions& options) {
  const DistanceOptions& distance = options.distance;
  if (distance.radius > 0) return index_.Build(cloud_, distance.radius * scale_, 1);
  if (distance.radius_share > 0) return index_.Build(cloud_, distance.radius_share, 1);
  const double by_noise = kRadiusPerNoise * noise_;
  const bool is_noisy = noise_ > 0 && by_noise > distance.radius_factor * index_.spacing();
  return index_.Build(cloud_, is_noisy ? by_noise : 0, distance.radius_factor);
}

absl::Status FrameTarget::Clean(const FitOptions& options) {
  outliers_ = 0;
  if (options.target.remove_outliers) {
    const std::vector<int32_t> outliers = FindOutliers(index_.grid());
    outliers_ = static_cast<int64_t>(outliers.size());
    if (outliers_ > 0) {
      RemovePoints(outliers, &cloud_);
      RETURN_IF_ERROR(Index(options));
    }
  }
  if (options.target.repair_normals && RepairNormals(index_.grid(), &cloud_) > 0) {
    RETURN_IF_ERROR(Index(options));
  }
  return absl::OkStatus();
}

// In the order of the grid: neighbours follow one another, and so do the patches that they lie on.
void FrameTarget::DrawCovered(int64_t count) {
  const CellGrid& grid = index_.grid();
  count = std::min(count, grid.size());
  covered_.points.resize(3, count);
  covered_.normals.resize(3, count);
  for (int64_t k = 0; k < count; ++k) {
    const int64_t i = k * grid.size() / count;
    covered_.points.col(k) = grid.point_at(i);
    covered_.normals.col(k) = grid.normal_at(i);
  }
}

void FrameTarget::PlaceLandmarks(const FrameSource& source, const Normalization& normalization) {
  landmarks_.clear();
  if (source.landmarks != nullptr) landmarks_ = *source.landmarks;
  for (Landmark& landmark : landmarks_) {
    landmark.position = normalization.ToUnit(Points3d(landmark.position));
  }
  target_.landmarks = landmarks_;
}

void FrameTarget::TraceBoundary(const FrameSource& source, const Normalization& normalization) {
  boundary_ =
      source.mesh != nullptr
          ? BoundaryOfMesh({normalization.ToUnit(source.mesh->vertices), source.mesh->triangles},
                           index_.spacing())
          : BoundaryOfCloud(index_.grid(), index_.spacing());
  target_.boundary = &boundary_;
}

double FrameTarget::ArapWeight(const FitOptions& options, int64_t control_vertices) const {
  if (options.arap.weight.has_value()) return *options.arap.weight;
  const double noise = noise_ / kNoiseOfDoubleWeight;
  return kArapWeightPerVertex * static_cast<double>(control_vertices) * (1 + noise * noise);
}

}  // namespace cagefit
