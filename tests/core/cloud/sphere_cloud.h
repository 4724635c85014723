// A cloud whose distance field is known.
#ifndef CAGEFIT_TESTS_CORE_CLOUD_SPHERE_CLOUD_H_
#define CAGEFIT_TESTS_CORE_CLOUD_SPHERE_CLOUD_H_

#include <cmath>
#include <cstdint>

#include "core/cloud/point_cloud.h"

namespace cagefit::testing {

// Points on the unit sphere, evenly spread (Fibonacci), with outward normals.
inline PointCloud SphereCloud(int64_t count) {
  PointCloud cloud;
  cloud.points.resize(3, count);
  for (int64_t i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double a = 2.399963229728653 * static_cast<double>(i);
    const double r = std::sqrt(1 - z * z);
    cloud.points.col(i) = Eigen::Vector3d(r * std::cos(a), r * std::sin(a), z).cast<float>();
  }
  cloud.normals = cloud.points;
  return cloud;
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_CLOUD_SPHERE_CLOUD_H_
