#include "core/cloud/target_index.h"

#include <algorithm>

#include "absl/strings/str_format.h"
#include "core/base/status.h"

namespace cagefit {

namespace {

constexpr int kSpacingNeighbor = 6;
constexpr int64_t kSpacingSamples = 1024;

// Cells between half and one and a half of 2 h serve the sums about equally well; beyond that,
// sorting again pays.
constexpr double kLeastCellPerDiameter = 0.5, kMostCellPerDiameter = 1.5;

}  // namespace

absl::Status TargetIndex::Build(const PointCloud& cloud, double radius, double radius_factor) {
  cloud_ = &cloud;
  lazy_ = std::make_unique<LazyTree>();
  // First guess: the points cover about half of their bounding box's faces, one in each square of
  // side s; then the 6th neighbour lies near 1.4 s.
  const Eigen::Vector3d size = BoundingBox(cloud.points).size();
  const double area = size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
  const double guess = 1.4 * std::sqrt(area / std::max<int64_t>(1, cloud.size()));
  grid_.Build(cloud, 2 * (radius > 0 ? radius : radius_factor * guess));
  if (grid_.size() < kMinTargetPoints) {
    return absl::InvalidArgumentError(
        absl::StrFormat("target: %d points have a usable normal; at least %d are needed",
                        grid_.size(), kMinTargetPoints));
  }
  spacing_ = MedianSpacing();
  radius_ = radius > 0 ? radius : radius_factor * spacing_;
  if (!(radius_ > 0)) {
    return absl::InvalidArgumentError(
        "target: half of the points coincide with six others, so they have no spacing; set a "
        "radius");
  }
  const double cell_per_diameter = grid_.cell() / (2 * radius_);
  if (cell_per_diameter < kLeastCellPerDiameter || cell_per_diameter > kMostCellPerDiameter) {
    grid_.Build(cloud, 2 * radius_);
  }
  return absl::OkStatus();
}

double TargetIndex::MedianSpacing() {
  const int64_t samples = std::min(grid_.size(), kSpacingSamples);
  distances_.clear();
  for (int64_t s = 0; s < samples; ++s) {
    const int64_t i = s * grid_.size() / samples;
    const Eigen::Vector3d x(grid_.point(0)[i], grid_.point(1)[i], grid_.point(2)[i]);
    distances_.push_back(grid_.KthDistance(x, kSpacingNeighbor + 1, &scratch_));
  }
  std::nth_element(distances_.begin(), distances_.begin() + samples / 2, distances_.end());
  return distances_[samples / 2];
}

int32_t TargetIndex::Nearest(const Eigen::Vector3d& x) const {
  std::call_once(lazy_->once, [&] { lazy_->tree = std::make_unique<KdTree>(cloud_->points); });
  int32_t index = 0;
  float squared_distance = 0;
  lazy_->tree->Nearest(x.cast<float>(), 1, &index, &squared_distance);
  return index;
}

}  // namespace cagefit
