#include "core/cloud/repair_normals.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr double kRadiusPerCell = 0.65;
constexpr double kClearMajority = 2.0 / 3;
constexpr int kFewestNeighbors = 12;
// A cell's sum of normals stands for its points where there are some, most of one mind.
constexpr int32_t kFewestInCell = 8;
constexpr float kOneMind = 0.6f;  // length of the mean normal
constexpr float kAgrees = 0.1f;   // cosine

struct Votes {
  int neighbors = 0;
  float against = 0, all = 0;
};

Votes CountVotes(const CellGrid& grid, int32_t i, double radius) {
  const Eigen::Vector3f x = grid.point_at(i), n = grid.normal_at(i);
  const float inverse_square = static_cast<float>(1 / (radius * radius));
  Votes votes;
  grid.ForEachRun(x.cast<double>(), radius, [&](int32_t begin, int32_t end) {
    for (int32_t j = begin; j < end; ++j) {
      const float weight = 1 - (grid.point_at(j) - x).squaredNorm() * inverse_square;
      if (weight <= 0 || j == i) continue;
      const float agreement = weight * n.dot(grid.normal_at(j));
      votes.all += std::abs(agreement);
      votes.against += std::max(0.0f, -agreement);
      ++votes.neighbors;
    }
  });
  return votes;
}

bool IsAgainstItsNeighbors(const CellGrid& grid, int32_t i, double radius) {
  Votes votes = CountVotes(grid, i, radius);
  if (votes.neighbors < kFewestNeighbors) votes = CountVotes(grid, i, 2 * radius);
  return votes.neighbors >= kFewestNeighbors && votes.against > kClearMajority * votes.all;
}

}  // namespace

int64_t RepairNormals(const CellGrid& grid, PointCloud* cloud) {
  const double radius = kRadiusPerCell * grid.cell();
  return std::lround(ParallelSum(grid.cells(), 64, [&](int64_t begin, int64_t end) {
    int64_t turned = 0;
    for (int64_t c = begin; c < end; ++c) {
      const int32_t first = grid.cell_begin(c), last = grid.cell_begin(c + 1);
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int32_t i = first; i < last; ++i) sum += grid.normal_at(i);
      const float length = sum.norm();
      const bool speaks_for_all =
          last - first >= kFewestInCell && length > kOneMind * static_cast<float>(last - first);
      for (int32_t i = first; i < last; ++i) {
        if (speaks_for_all && grid.normal_at(i).dot(sum) > kAgrees * length) continue;
        if (!IsAgainstItsNeighbors(grid, i, radius)) continue;
        cloud->normals.col(grid.source(i)) *= -1;
        ++turned;
      }
    }
    return static_cast<double>(turned);
  }));
}

}  // namespace cagefit
