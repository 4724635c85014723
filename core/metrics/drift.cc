#include "core/metrics/drift.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 1024;

}  // namespace

DriftMeter::DriftMeter(const TriangleMesh& fit, const Points3d& truth)
    : triangles_(fit.triangles), bound_(truth.cols()), truth_(truth) {
  const TriangleBvh surface(fit.vertices, fit.triangles);
  ParallelFor(truth.cols(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) bound_[i] = surface.Closest(truth.col(i));
  });
}

DriftStats DriftMeter::Measure(const Points3d& fit_vertices, const Points3d& truth) const {
  assert(truth.cols() == truth_.cols());
  DriftStats stats;
  double squares = 0;
  for (int64_t i = 0; i < truth.cols(); ++i) {
    const ClosestPoint& at = bound_[i];
    const Eigen::Vector3d a = fit_vertices.col(triangles_(0, at.triangle));
    const Eigen::Vector3d ab = fit_vertices.col(triangles_(1, at.triangle)) - a;
    const Eigen::Vector3d ac = fit_vertices.col(triangles_(2, at.triangle)) - a;
    const Eigen::Vector3d moved = a + at.u * ab + at.v * ac - at.point;
    const Eigen::Vector3d drift = moved - (truth.col(i) - truth_.col(i));
    const Eigen::Vector3d normal = ab.cross(ac).normalized();
    stats.mean += drift.norm();
    squares += drift.squaredNorm();
    stats.max = std::max(stats.max, drift.norm());
    stats.tangential_mean += (drift - normal.dot(drift) * normal).norm();
  }
  const auto count = static_cast<double>(std::max<int64_t>(1, truth.cols()));
  stats.mean /= count;
  stats.tangential_mean /= count;
  stats.rms = std::sqrt(squares / count);
  return stats;
}

}  // namespace cagefit
