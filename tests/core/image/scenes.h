// Meshes and cameras that the renderer's tests look at.
#ifndef CAGEFIT_TESTS_CORE_IMAGE_SCENES_H_
#define CAGEFIT_TESTS_CORE_IMAGE_SCENES_H_

#include <algorithm>

#include "core/base/random.h"
#include "core/image/camera.h"
#include "core/mesh/triangle_mesh.h"
#include "tests/support/shapes.h"

namespace cagefit::testing {

inline Camera TestCamera(int size, double distance = 3.5) {
  return LookAt(distance * Eigen::Vector3d(0.3, 0.4, 0.87).normalized(), Eigen::Vector3d::Zero(),
                Eigen::Vector3d::UnitY(), 60 * M_PI / 180, size);
}

// A wide image whose pixels are not square.
inline Camera WideCamera() {
  Camera camera = TestCamera(96);
  camera.width = 150;
  camera.cx = 77.25;
  camera.fy *= 1.1;
  return camera;
}

// Triangles of no common edges, of all sizes, some of which leave the image.
inline TriangleMesh TriangleSoup(int count, double size, uint64_t seed) {
  Random random(seed);
  TriangleMesh mesh;
  mesh.vertices.resize(3, 3 * count);
  mesh.triangles.resize(3, count);
  for (int f = 0; f < count; ++f) {
    const Eigen::Vector3d center = 0.9 * random.NormalVector();
    const double own = size * random.Uniform(0.1, 1);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d v = center + own * random.NormalVector();
      mesh.vertices.col(3 * f + k) = v / std::max(1.0, v.norm() / 2.5);  // in front of the camera
      mesh.triangles(k, f) = 3 * f + k;
    }
  }
  return mesh;
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_IMAGE_SCENES_H_
