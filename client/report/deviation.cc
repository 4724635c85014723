#include "client/report/deviation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/cloud/kd_tree.h"
#include "core/cloud/point_cloud.h"
#include "core/cloud/spacing.h"

namespace cagefit::client {
namespace {

constexpr int64_t kGrain = 512;
constexpr double kReachInSpacings = 3;  // as core/metrics/surface_metrics.h has it
constexpr int kNeighbors = 7;

template <typename Deviation>
std::vector<double> ForEach(int64_t count, const Deviation& deviation) {
  std::vector<double> deviations(count);
  ParallelFor(count, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) deviations[i] = deviation(i);
  });
  return deviations;
}

std::vector<double> ToMesh(const Points3d& vertices, const Points3d& normals,
                           const TriangleMesh& target) {
  const TriangleBvh bvh(target.vertices, target.triangles);
  return ForEach(vertices.cols(), [&](int64_t i) {
    const Eigen::Vector3d x = vertices.col(i);
    const ClosestPoint closest = bvh.Closest(x);
    return std::copysign(closest.distance, normals.col(i).dot(x - closest.point));
  });
}

// Median of the signed heights of x over the planes of `count` points.
double MedianHeight(const Eigen::Vector3d& x, const Eigen::Vector3d& normal,
                    const PointCloud& target, const int32_t* points, int count) {
  std::array<double, kNeighbors> heights;
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3d offset = x - target.points.col(points[k]).cast<double>();
    Eigen::Vector3d n = normal;
    if (target.has_normals()) n = target.normals.col(points[k]).cast<double>();
    heights[k] = std::copysign(1.0, n.dot(normal)) * n.dot(offset);
  }
  std::nth_element(heights.begin(), heights.begin() + count / 2, heights.begin() + count);
  return heights[count / 2];
}

std::vector<double> ToCloud(const Points3d& vertices, const Points3d& normals,
                            const PointCloud& target) {
  const KdTree tree(target.points);
  const double reach = kReachInSpacings * MedianSpacing(target.points, tree);
  return ForEach(vertices.cols(), [&](int64_t i) {
    const Eigen::Vector3d x = vertices.col(i), normal = normals.col(i);
    int32_t nearest[kNeighbors];
    float squared[kNeighbors];
    const int found = tree.Nearest(x.cast<float>(), kNeighbors, nearest, squared);
    const double height = MedianHeight(x, normal, target, nearest, found);
    const Eigen::Vector3d offset = x - target.points.col(nearest[0]).cast<double>();
    const double lateral = std::sqrt(std::max(0.0, offset.squaredNorm() - height * height));
    return lateral <= reach ? height : std::copysign(offset.norm(), normal.dot(offset));
  });
}

}  // namespace

std::vector<double> SurfaceDeviations(const TriangleMesh& surface, const Geometry& target) {
  const Points3d normals = VertexNormals(surface);
  return target.is_cloud() ? ToCloud(surface.vertices, normals, client::ToCloud(target))
                           : ToMesh(surface.vertices, normals, target.mesh);
}

std::vector<double> PointDeviations(const Points3d& points, const TriangleMesh& surface,
                                    const TriangleBvh& bvh) {
  return ForEach(points.cols(), [&](int64_t i) {
    const ClosestPoint closest = bvh.Closest(points.col(i));
    const auto corner = [&](int c) -> Eigen::Vector3d {
      return surface.vertices.col(surface.triangles(c, closest.triangle));
    };
    const Eigen::Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    return std::copysign(closest.distance, normal.dot(closest.point - points.col(i)));
  });
}

}  // namespace cagefit::client
