// One frame's target, ready for the distance term: cells for the field, a k-d tree for what lies
// far off.
#ifndef CAGEFIT_CORE_CLOUD_TARGET_INDEX_H_
#define CAGEFIT_CORE_CLOUD_TARGET_INDEX_H_

#include <memory>
#include <mutex>
#include <vector>

#include "core/cloud/cell_grid.h"
#include "core/cloud/kd_tree.h"
#include "core/cloud/point_cloud.h"

namespace cagefit {

// Queries are thread-safe after Build.
class TargetIndex {
 public:
  // Takes a cloud with normals; buffers keep their capacity. The radius h is `radius` where it is
  // positive, else `radius_factor` times the spacing. INVALID_ARGUMENT when fewer than
  // kMinTargetPoints points have a usable normal.
  absl::Status Build(const PointCloud& cloud, double radius, double radius_factor);

  const CellGrid& grid() const { return grid_; }
  double radius() const { return radius_; }  // h
  double spacing() const {
    return spacing_;
  }  // median distance to the 6th neighbour, of at most 1,024 points

  // Nearest point to x, as a column of points(). The tree behind it is built on first use: a frame
  // near its predecessor never asks.
  int32_t Nearest(const Eigen::Vector3d& x) const;
  Eigen::Vector3d point(int32_t k) const { return cloud_->points.col(k).cast<double>(); }
  Eigen::Vector3d normal(int32_t k) const { return cloud_->normals.col(k).cast<double>(); }

 private:
  struct LazyTree {
    std::once_flag once;
    std::unique_ptr<KdTree> tree;
  };
  double MedianSpacing();

  const PointCloud* cloud_ = nullptr;  // not owned
  CellGrid grid_;
  double radius_ = 0, spacing_ = 0;
  std::unique_ptr<LazyTree> lazy_;
  std::vector<float> scratch_;
  std::vector<double> distances_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_TARGET_INDEX_H_
