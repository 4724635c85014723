#include "core/cloud/normals.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/base/parallel.h"
#include "core/cloud/cell_grid.h"
#include "core/cloud/kd_tree.h"
#include "core/cloud/noise.h"

namespace cagefit {

namespace {

constexpr int kMaxNeighbors = 100;

// The k nearest points of each point, itself among them.
std::vector<int32_t> NeighborGraph(const PointCloud& cloud, int k) {
  const KdTree tree(cloud.points);
  std::vector<int32_t> neighbors(cloud.size() * k);
  ParallelFor(cloud.size(), 1024, [&](int64_t begin, int64_t end) {
    float squared[kMaxNeighbors];
    for (int64_t i = begin; i < end; ++i) {
      tree.Nearest(cloud.points.col(i), k, &neighbors[i * k], squared);
    }
  });
  return neighbors;
}

Eigen::Vector3f LeastVariance(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
  return eigen.eigenvectors().col(0).cast<float>();
}

Eigen::Vector3f NormalOfNeighbors(const PointCloud& cloud, const int32_t* neighbors, int k) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int j = 0; j < k; ++j) mean += cloud.points.col(neighbors[j]).cast<double>();
  mean /= k;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (int j = 0; j < k; ++j) {
    const Eigen::Vector3d d = cloud.points.col(neighbors[j]).cast<double>() - mean;
    covariance += d * d.transpose();
  }
  return LeastVariance(covariance);
}

// The same of the points within `radius`, those at the rim counting less.
Eigen::Vector3f NormalOfBall(const CellGrid& grid, const Eigen::Vector3d& x, double radius) {
  const double inverse_square = 1 / (radius * radius);
  double weights = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  grid.ForEachRun(x, radius, [&](int32_t begin, int32_t end) {
    for (int32_t j = begin; j < end; ++j) {
      const Eigen::Vector3d d = grid.point_at(j).cast<double>() - x;
      const double weight = 1 - d.squaredNorm() * inverse_square;
      if (weight <= 0) continue;
      weights += weight;
      sum += weight * d;
      squares += (weight * d) * d.transpose();
    }
  });
  return LeastVariance(squares - sum * sum.transpose() / weights);
}

// Radius at which the plane of a ball stands out of the noise; 0 where the nearest neighbours will
// do. Of N points within r, pi N = a r^2, the plane is off by about 2 sigma / (r sqrt(N)) rad.
double RadiusForNoise(const PointCloud& cloud, const std::vector<int32_t>& neighbors, int k) {
  constexpr int64_t kSamples = 1000;
  constexpr double kTolerable = 0.05;   // rad
  constexpr double kLeastInSigmas = 4;  // below, the ball cuts the noise off and is round
  constexpr double kWorthwhile = 1.2;   // in distances to the k-th neighbour
  std::vector<float> distances;
  for (int64_t i = 0; i < cloud.size(); i += std::max<int64_t>(1, cloud.size() / kSamples)) {
    distances.push_back((cloud.points.col(neighbors[i * k + k - 1]) - cloud.points.col(i)).norm());
  }
  const auto middle = distances.begin() + static_cast<int64_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  const double reach = *middle;
  if (!(reach > 0)) return 0;
  CellGrid grid;
  grid.Build(cloud, 2 * reach);
  const double sigma = EstimateNoise(grid).sigma;
  const double radius =
      std::max(std::sqrt(2 * sigma * reach / (kTolerable * std::sqrt(k))), kLeastInSigmas * sigma);
  return radius > kWorthwhile * reach ? radius : 0;
}

// Every s-th point, so many that a ball of `radius` holds some hundreds.
PointCloud Thinned(const PointCloud& cloud, double radius) {
  constexpr int64_t kBalls = 64, kMostInBall = 400;
  int64_t inside = 0;
  for (int64_t b = 0; b < kBalls; ++b) {
    const Eigen::Vector3f x = cloud.points.col(b * cloud.size() / kBalls);
    const float squared = static_cast<float>(radius * radius);
    inside += ((cloud.points.colwise() - x).colwise().squaredNorm().array() < squared).count();
  }
  const int64_t stride = std::max<int64_t>(1, inside / (kBalls * kMostInBall));
  PointCloud thin;
  thin.points.resize(3, (cloud.size() + stride - 1) / stride);
  for (int64_t i = 0; i < thin.size(); ++i) thin.points.col(i) = cloud.points.col(i * stride);
  return thin;
}

// Propagates signs along a minimum spanning tree (Prim) of the part that holds `seed` and returns
// the part's points.
std::vector<int32_t> OrientPart(const std::vector<std::vector<int32_t>>& adjacent, int32_t seed,
                                std::vector<char>* done, Points3f* normals) {
  struct Edge {
    float cost;
    int32_t to, from;
    bool operator>(const Edge& o) const {
      return std::tie(cost, to, from) > std::tie(o.cost, o.to, o.from);
    }
  };
  std::priority_queue<Edge, std::vector<Edge>, std::greater<>> edges;
  std::vector<int32_t> part;
  edges.push({0, seed, seed});
  while (!edges.empty()) {
    const Edge edge = edges.top();
    edges.pop();
    if ((*done)[edge.to]) continue;
    (*done)[edge.to] = 1;
    part.push_back(edge.to);
    if (normals->col(edge.to).dot(normals->col(edge.from)) < 0) normals->col(edge.to) *= -1;
    for (const int32_t next : adjacent[edge.to]) {
      if ((*done)[next]) continue;
      const float agreement = std::abs(normals->col(next).dot(normals->col(edge.to)));
      edges.push({1 - agreement, next, edge.to});
    }
  }
  return part;
}

// True when the normals of the part point inwards on the whole: rays from the part's centre along a
// closed surface's outward normals leave it, so that sum n . (p - centre), three times the volume
// over the density, is positive. Where an open surface leaves the sum near zero, the topmost point
// decides [hoppe1992].
bool PointsInwards(const PointCloud& cloud, const std::vector<int32_t>& part) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const int32_t i : part) centre += cloud.points.col(i).cast<double>();
  centre /= static_cast<double>(part.size());
  double flux = 0, reach = 0;
  int32_t top = part[0];
  for (const int32_t i : part) {
    const Eigen::Vector3d d = cloud.points.col(i).cast<double>() - centre;
    flux += cloud.normals.col(i).cast<double>().dot(d);
    reach += d.norm();
    if (cloud.points(2, i) > cloud.points(2, top)) top = i;
  }
  constexpr double kClearShare = 0.1;
  if (std::abs(flux) > kClearShare * reach) return flux < 0;
  return cloud.normals(2, top) < 0;
}

void OrientConsistently(const std::vector<int32_t>& neighbors, int k, PointCloud* cloud) {
  const int32_t count = static_cast<int32_t>(cloud->size());
  std::vector<std::vector<int32_t>> adjacent(count);
  for (int32_t i = 0; i < count; ++i) {
    for (int j = 0; j < k; ++j) {
      const int32_t other = neighbors[static_cast<int64_t>(i) * k + j];
      if (other == i) continue;
      adjacent[i].push_back(other);
      adjacent[other].push_back(i);
    }
  }
  std::vector<char> done(count, 0);
  for (int32_t seed = 0; seed < count; ++seed) {
    if (done[seed]) continue;
    const std::vector<int32_t> part = OrientPart(adjacent, seed, &done, &cloud->normals);
    if (PointsInwards(*cloud, part)) {
      for (const int32_t i : part) cloud->normals.col(i) *= -1;
    }
  }
}

}  // namespace

absl::Status EstimateNormals(const NormalOptions& options, PointCloud* cloud) {
  const int k = options.neighbors;
  if (k < 3 || k > kMaxNeighbors) {
    return absl::InvalidArgumentError(
        absl::StrFormat("neighbors is %d; it must be from 3 to %d", k, kMaxNeighbors));
  }
  if (cloud->size() < k) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "points: %d; normals from %d neighbours need at least as many", cloud->size(), k));
  }
  const std::vector<int32_t> neighbors = NeighborGraph(*cloud, k);
  cloud->normals.resize(3, 0);
  const double radius = RadiusForNoise(*cloud, neighbors, k);
  CellGrid grid;
  if (radius > 0) grid.Build(Thinned(*cloud, radius), radius);
  cloud->normals.resize(3, cloud->size());
  ParallelFor(cloud->size(), 256, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      cloud->normals.col(i) = radius > 0
                                  ? NormalOfBall(grid, cloud->points.col(i).cast<double>(), radius)
                                  : NormalOfNeighbors(*cloud, &neighbors[i * k], k);
    }
  });
  if (options.sensor.has_value()) {
    const Eigen::Vector3f sensor = options.sensor->cast<float>();
    for (int64_t i = 0; i < cloud->size(); ++i) {
      if (cloud->normals.col(i).dot(sensor - cloud->points.col(i)) < 0) cloud->normals.col(i) *= -1;
    }
    return absl::OkStatus();
  }
  OrientConsistently(neighbors, k, cloud);
  return absl::OkStatus();
}

}  // namespace cagefit
