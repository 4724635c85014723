#include "core/image/projected_mesh.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 4096;

}  // namespace

void ProjectMesh(const Points3d& vertices, const Camera& camera, ProjectedMesh* out) {
  const int64_t n = vertices.cols();
  out->points.resize(3, n);
  ParallelFor(n, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      out->points.col(i) = camera.R * vertices.col(i) + camera.t;
    }
  });
  const double farthest = n > 0 ? out->points.row(2).maxCoeff() : 0;
  out->near_depth = kNearShare * std::max(0.0, farthest);
  ParallelFor(n, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const double z = out->points(2, i);
      const double s = z > out->near_depth ? 1 / z : 0;
      out->points(0, i) = camera.fx * s * out->points(0, i) + camera.cx;
      out->points(1, i) = camera.fy * s * out->points(1, i) + camera.cy;
    }
  });
}

Eigen::Matrix<double, 2, 3> ProjectionJacobian(const Camera& camera, const Eigen::Vector3d& X) {
  // u = fx x / z + cx with (x, y, z) = R X + t.
  const Eigen::Vector3d x = camera.R * X + camera.t;
  const double s = 1 / x[2];
  Eigen::Matrix<double, 2, 3> J;
  J.row(0) = camera.fx * s * (camera.R.row(0) - x[0] * s * camera.R.row(2));
  J.row(1) = camera.fy * s * (camera.R.row(1) - x[1] * s * camera.R.row(2));
  return J;
}

void AddVertexGradient(const Points3d& vertices, const Camera& camera,
                       const Eigen::Matrix<double, 2, Eigen::Dynamic>& by_pixel,
                       Points3d* gradient) {
  ParallelFor(vertices.cols(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const auto g = by_pixel.col(i);
      if (g[0] == 0 && g[1] == 0) continue;
      gradient->col(i) += ProjectionJacobian(camera, vertices.col(i)).transpose() * g;
    }
  });
}

}  // namespace cagefit
