// Small captures for tests of the service: clouds on a moving, breathing ellipsoid, and a cage that
// fits them.
#ifndef CAGEFIT_TESTS_SUPPORT_FRAMES_H_
#define CAGEFIT_TESTS_SUPPORT_FRAMES_H_

#include <cmath>
#include <string>
#include <utility>

#include "core/cloud/point_cloud.h"
#include "core/codec/draco_codec.h"
#include "core/mesh/control_mesh.h"
#include "tests/support/shapes.h"

namespace cagefit::testing {

// An even cloud with exact normals on the ellipsoid around `center` with half axes `axes`.
inline PointCloud CloudOnEllipsoid(int64_t count, const Eigen::Vector3d& center,
                                   const Eigen::Vector3d& axes) {
  PointCloud cloud;
  cloud.points.resize(3, count);
  cloud.normals.resize(3, count);
  for (int64_t i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double turn = 2.399963229728653 * static_cast<double>(i);
    const double r = std::sqrt(1 - z * z);
    const Eigen::Vector3d n(r * std::cos(turn), r * std::sin(turn), z);
    cloud.points.col(i) = (center + axes.cwiseProduct(n)).cast<float>();
    cloud.normals.col(i) = n.cwiseQuotient(axes).normalized().cast<float>();
  }
  return cloud;
}

inline PointCloud SphereCloud(int64_t count, const Eigen::Vector3d& center, double radius = 1) {
  return CloudOnEllipsoid(count, center, Eigen::Vector3d::Constant(radius));
}

// Time step `frame` of a sequence that stays within [-2, 2]^3.
inline PointCloud MovingCloud(int frame, int64_t count = 500) {
  const double t = 0.05 * frame;
  return CloudOnEllipsoid(
      count, {0.5 * std::sin(t), 0.4 * std::sin(0.7 * t), 0.3 * (1 - std::cos(t))},
      {1 + 0.2 * std::sin(1.3 * t), 1 - 0.1 * std::sin(t), 1 + 0.1 * std::sin(0.9 * t)});
}

// As a client sends it.
inline std::string FrameBytes(const PointCloud& cloud) {
  return EncodeDracoCloud(cloud, DracoCloudOptions()).value();
}

// A cage around the first clouds of the sequence: 10 * 4^levels + 2 control vertices.
inline ControlMesh FrameCage(int levels = 1) {
  TriangleMesh mesh = Icosphere(levels, 1.1);
  return ControlMesh::Create(std::move(mesh.vertices), std::move(mesh.triangles)).value();
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_FRAMES_H_
