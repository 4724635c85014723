#include "core/mesh/triangle_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace cagefit {

Points3d VertexNormals(const TriangleMesh& mesh) {
  Points3d normals = Points3d::Zero(3, mesh.vertices.cols());
  for (int64_t f = 0; f < mesh.triangles.cols(); ++f) {
    const Eigen::Vector3i t = mesh.triangles.col(f);
    const Eigen::Vector3d p[3] = {mesh.vertices.col(t[0]), mesh.vertices.col(t[1]),
                                  mesh.vertices.col(t[2])};
    const Eigen::Vector3d cross = (p[1] - p[0]).cross(p[2] - p[0]);
    const double length = cross.norm();
    if (!(length > 0)) continue;
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d a = p[(c + 1) % 3] - p[c], b = p[(c + 2) % 3] - p[c];
      // atan2 stays exact for needles, where acos of the cosine loses half of the digits.
      normals.col(t[c]) += std::atan2(length, a.dot(b)) / length * cross;
    }
  }
  for (int64_t v = 0; v < normals.cols(); ++v) {
    const double length = normals.col(v).norm();
    if (length > 0) normals.col(v) /= length;
  }
  return normals;
}

}  // namespace cagefit
