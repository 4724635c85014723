#include "core/metrics/surface_metrics.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"
#include "core/cloud/kd_tree.h"
#include "core/cloud/spacing.h"
#include "core/metrics/surface_samples.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 1024;
constexpr double kReachInSpacings = 3;

// Of distance(i), i = 0 to count - 1; the sums do not depend on the number of threads.
template <typename Distance>
DistanceStats Collect(int64_t count, const Distance& distance) {
  std::vector<double> distances(count);
  ParallelFor(count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) distances[i] = distance(i);
  });
  DistanceStats stats;
  stats.samples = count;
  if (count == 0) return stats;
  double sum = 0, squares = 0;
  for (const double d : distances) {
    sum += d;
    squares += d * d;
    stats.max = std::max(stats.max, d);
  }
  stats.mean = sum / static_cast<double>(count);
  stats.rms = std::sqrt(squares / static_cast<double>(count));
  return stats;
}

DistanceStats DistancesToCloud(const Points3d& points, const PointCloud& target) {
  const KdTree tree(target.points);
  const double reach = kReachInSpacings * MedianSpacing(target.points, tree);
  return Collect(points.cols(), [&](int64_t i) {
    int32_t nearest = 0;
    float squared = 0;
    tree.Nearest(points.col(i).cast<float>(), 1, &nearest, &squared);
    const Eigen::Vector3d offset = points.col(i) - target.points.col(nearest).cast<double>();
    if (!target.has_normals()) return offset.norm();
    const double height = std::abs(offset.dot(target.normals.col(nearest).cast<double>()));
    const double lateral = std::sqrt(std::max(0.0, offset.squaredNorm() - height * height));
    return lateral <= reach ? height : offset.norm();
  });
}

}  // namespace

double SurfaceMetrics::hausdorff() const { return std::max(target_to_fit.max, fit_to_target.max); }

double SurfaceMetrics::symmetric_rms() const {
  const double a = target_to_fit.rms, b = fit_to_target.rms;
  return std::sqrt((a * a + b * b) / 2);
}

DistanceStats DistancesToSurface(const Points3d& points, const TriangleBvh& surface) {
  return Collect(points.cols(), [&](int64_t i) { return surface.Closest(points.col(i)).distance; });
}

SurfaceMetrics CompareToMesh(const TriangleMesh& fit, const TriangleMesh& target, uint64_t seed) {
  const TriangleBvh fit_surface(fit.vertices, fit.triangles);
  const TriangleBvh target_surface(target.vertices, target.triangles);
  const Points3d on_target = SampleSurface(target, kMetricSamplesPerFace, seed);
  const Points3d on_fit = SampleSurface(fit, kMetricSamplesPerFace, seed);
  SurfaceMetrics metrics;
  metrics.diagonal = BoundingBox(on_target).diagonal();
  metrics.target_to_fit = DistancesToSurface(on_target, fit_surface);
  metrics.fit_to_target = DistancesToSurface(on_fit, target_surface);
  return metrics;
}

SurfaceMetrics CompareToCloud(const TriangleMesh& fit, const PointCloud& target, uint64_t seed) {
  const TriangleBvh fit_surface(fit.vertices, fit.triangles);
  SurfaceMetrics metrics;
  metrics.diagonal = BoundingBox(target.points).diagonal();
  metrics.target_to_fit = DistancesToSurface(target.points.cast<double>(), fit_surface);
  metrics.fit_to_target = DistancesToCloud(SampleSurface(fit, kMetricSamplesPerFace, seed), target);
  metrics.approximate = true;
  return metrics;
}

}  // namespace cagefit
