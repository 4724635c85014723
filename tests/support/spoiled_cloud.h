// Clouds with the faults of a capture, made from clean ones. Seeded.
#ifndef CAGEFIT_TESTS_CORE_CLOUD_SPOILED_CLOUD_H_
#define CAGEFIT_TESTS_CORE_CLOUD_SPOILED_CLOUD_H_

#include <cstdint>

#include "core/base/random.h"
#include "core/cloud/cell_grid.h"
#include "core/cloud/point_cloud.h"
#include "core/cloud/spacing.h"

namespace cagefit::testing {

inline double Diagonal(const PointCloud& cloud) { return BoundingBox(cloud.points).diagonal(); }

// Gaussian, isotropic, `share` of the diagonal.
inline PointCloud WithNoise(PointCloud cloud, double share, uint64_t seed = 1) {
  Random random(seed);
  const double sigma = share * Diagonal(cloud);
  for (int64_t i = 0; i < cloud.size(); ++i) {
    cloud.points.col(i) += (sigma * random.NormalVector()).cast<float>();
  }
  return cloud;
}

// `share` of the points more, uniform in the bounding box, with random normals, behind the others.
inline PointCloud WithOutliers(PointCloud cloud, double share, uint64_t seed = 2) {
  Random random(seed);
  const Box box = BoundingBox(cloud.points);
  const int64_t clean = cloud.size();
  const int64_t all = clean + static_cast<int64_t>(share * static_cast<double>(clean));
  cloud.points.conservativeResize(3, all);
  cloud.normals.conservativeResize(3, all);
  for (int64_t i = clean; i < all; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      cloud.points(axis, i) = static_cast<float>(random.Uniform(box.min[axis], box.max[axis]));
    }
    cloud.normals.col(i) = random.NormalVector().normalized().cast<float>();
  }
  return cloud;
}

// Each normal turned round with probability `share`.
inline PointCloud WithFlippedNormals(PointCloud cloud, double share, uint64_t seed = 3) {
  Random random(seed);
  for (int64_t i = 0; i < cloud.size(); ++i) {
    if (random.Uniform() < share) cloud.normals.col(i) *= -1;
  }
  return cloud;
}

// A grid as fine as that of a fit with default options.
inline CellGrid GridOf(const PointCloud& cloud) {
  CellGrid grid;
  grid.Build(cloud, 3.4 * MedianSpacing(cloud.points, KdTree(cloud.points)));
  return grid;
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_CLOUD_SPOILED_CLOUD_H_
