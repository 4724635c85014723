#include "core/cloud/outliers.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kSamples = 1024;
constexpr int kEnough = kOutlierNeighbors + 1;  // the point itself included
constexpr double kLeastReach = 2.5, kMostReach = 4;
constexpr double kDeviations = 5;
constexpr double kDeviationOfMedian = 1.4826;  // standard deviation of a normal distribution / MAD
// Of a sparse surface.
constexpr int kSurfaceNeighbors = 20;
constexpr double kSurfaceReach = 2;  // in r
constexpr double kFlat = 0.08;       // residual of the plane per distance of the farthest
constexpr double kOffPlane = 3;      // of the point itself, in residuals
constexpr double kSparserThanNeighbors = 2;

using Scratch = std::vector<std::pair<float, int32_t>>;  // squared distance, sorted index

// The `count` points nearest to sorted point i, itself included, in no order; fewer where there
// are not as many within `reach`.
void Nearest(const CellGrid& grid, int64_t i, size_t count, double reach, Scratch* out) {
  const Eigen::Vector3f x = grid.point_at(i);
  for (double radius = reach / 2; radius <= reach; radius *= 2) {
    const float squared_radius = static_cast<float>(radius * radius);
    out->clear();
    grid.ForEachRun(x.cast<double>(), radius, [&](int32_t begin, int32_t end) {
      for (int32_t j = begin; j < end; ++j) {
        const float squared = (grid.point_at(j) - x).squaredNorm();
        if (squared <= squared_radius) out->emplace_back(squared, j);
      }
    });
    if (out->size() >= count) {
      std::nth_element(out->begin(), out->begin() + static_cast<int64_t>(count) - 1, out->end());
      out->resize(count);
      return;
    }
  }
}

// Distance within which every point of a surface has its neighbours.
double Reach(const CellGrid& grid) {
  const int64_t samples = std::min(grid.size(), kSamples);
  std::vector<double> logs(samples);
  ParallelFor(samples, 64, [&](int64_t begin, int64_t end) {
    std::vector<float> scratch;
    for (int64_t s = begin; s < end; ++s) {
      const Eigen::Vector3d x = grid.point_at(s * grid.size() / samples).cast<double>();
      logs[s] = std::log(std::max(grid.KthDistance(x, kEnough, &scratch), 1e-30));
    }
  });
  const auto middle = logs.begin() + samples / 2;
  std::nth_element(logs.begin(), middle, logs.end());
  const double median = *middle;
  for (double& value : logs) value = std::abs(value - median);
  std::nth_element(logs.begin(), middle, logs.end());
  const double spread = std::exp(kDeviations * kDeviationOfMedian * *middle);
  return std::exp(median) * std::clamp(spread, kLeastReach, kMostReach);
}

// True when the cells around some cell hold too few points for a neighbourhood. Cells much larger
// than the reach cannot tell.
bool MayHaveOutliers(const CellGrid& grid, double reach) {
  if (grid.cell() > 2 * reach) return true;
  for (int64_t c = 0; c < grid.cells(); ++c) {
    int64_t around = 0;
    grid.ForEachRun(grid.point_at(grid.cell_begin(c)).cast<double>(), reach,
                    [&](int32_t begin, int32_t end) { around += end - begin; });
    if (around < kEnough) return true;
  }
  return false;
}

// At most kEnough: the points within `reach` of sorted point i, its own cell first.
int CountWithin(const CellGrid& grid, int64_t i, int32_t cell_begin, int32_t cell_end,
                double reach) {
  const float squared_reach = static_cast<float>(reach * reach);
  const float x = grid.point(0)[i], y = grid.point(1)[i], z = grid.point(2)[i];
  int count = 0;
  const auto add = [&](int32_t begin, int32_t end) {
    constexpr int32_t kStep = 16;
    for (int32_t j = begin; j < end && count < kEnough; j += kStep) {
      const int32_t stop = std::min(end, j + kStep);
      for (int32_t k = j; k < stop; ++k) {
        const float dx = grid.point(0)[k] - x;
        const float dy = grid.point(1)[k] - y;
        const float dz = grid.point(2)[k] - z;
        count += dx * dx + dy * dy + dz * dz <= squared_reach;
      }
    }
  };
  add(cell_begin, cell_end);
  if (count >= kEnough) return kEnough;
  count = 0;
  grid.ForEachRun(Eigen::Vector3d(x, y, z), reach, add);
  return std::min(count, kEnough);
}

// Distance to the farthest of the nearest points, after Nearest.
double Farthest(const Scratch& nearest) {
  return std::sqrt(static_cast<double>(std::max_element(nearest.begin(), nearest.end())->first));
}

// True when the points nearest to sorted point i, without it, lie along a plane that passes by it.
bool LiesInPlane(const CellGrid& grid, int64_t i, const Scratch& nearest) {
  const Eigen::Vector3d x = grid.point_at(i).cast<double>();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  for (const auto& [squared, j] : nearest) {
    if (j == i) continue;
    const Eigen::Vector3d d = grid.point_at(j).cast<double>() - x;
    mean += d;
    squares += d * d.transpose();
  }
  const double count = static_cast<double>(nearest.size() - 1);
  mean /= count;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(squares / count - mean * mean.transpose());
  const double residual = std::sqrt(std::max(0.0, eigen.eigenvalues()[0]));
  const double farthest = Farthest(nearest);
  const double off_plane = std::abs(eigen.eigenvectors().col(0).dot(mean));
  const double allowed = std::max(kOffPlane * residual, kFlat / 8 * farthest);
  return residual < kFlat * farthest && off_plane < allowed;
}

bool IsSparseSurface(const CellGrid& grid, int64_t i, double reach, Scratch* nearest,
                     Scratch* second) {
  const double farthest_reach = kSurfaceReach * reach;
  Nearest(grid, i, kSurfaceNeighbors + 1, farthest_reach, nearest);
  if (nearest->size() < kSurfaceNeighbors + 1 || !LiesInPlane(grid, i, *nearest)) return false;
  const double own = Farthest(*nearest);
  int sparse = 0;
  for (const auto& [squared, j] : *nearest) {
    Nearest(grid, j, kSurfaceNeighbors + 1, farthest_reach, second);
    sparse += second->size() > kSurfaceNeighbors && own < kSparserThanNeighbors * Farthest(*second);
  }
  return 2 * sparse > kSurfaceNeighbors;
}

}  // namespace

std::vector<int32_t> FindOutliers(const CellGrid& grid) {
  std::vector<int32_t> outliers;
  if (grid.size() < kEnough) return outliers;
  const double reach = Reach(grid);
  if (!MayHaveOutliers(grid, reach)) return outliers;
  std::vector<char> out(grid.size(), 0);
  ParallelFor(grid.cells(), 64, [&](int64_t begin, int64_t end) {
    Scratch nearest, second;
    for (int64_t c = begin; c < end; ++c) {
      const int32_t first = grid.cell_begin(c), last = grid.cell_begin(c + 1);
      for (int32_t i = first; i < last; ++i) {
        out[i] = CountWithin(grid, i, first, last, reach) < kEnough &&
                 !IsSparseSurface(grid, i, reach, &nearest, &second);
      }
    }
  });
  for (int64_t i = 0; i < grid.size(); ++i) {
    if (out[i]) outliers.push_back(grid.source(i));
  }
  std::sort(outliers.begin(), outliers.end());
  return outliers;
}

void RemovePoints(const std::vector<int32_t>& indices, PointCloud* cloud) {
  const bool oriented = cloud->has_normals();
  int64_t kept = 0;
  size_t next = 0;
  for (int64_t i = 0; i < cloud->size(); ++i) {
    if (next < indices.size() && indices[next] == i) {
      ++next;
      continue;
    }
    cloud->points.col(kept) = cloud->points.col(i);
    if (oriented) cloud->normals.col(kept) = cloud->normals.col(i);
    ++kept;
  }
  cloud->points.conservativeResize(3, kept);
  if (oriented) cloud->normals.conservativeResize(3, kept);
}

}  // namespace cagefit
