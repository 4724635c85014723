#include "core/fit/target_distances.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/mesh/triangle_bvh.h"
#include "core/subdiv/limit.h"

namespace cagefit {

namespace {

// The chords of a limit mesh cut off its curves; with about so many triangles that is a few
// thousandths of a percent of the diagonal. Three levels where they suffice, as the reports use.
constexpr int64_t kFineTriangles = 200'000;
constexpr int kMostLevels = 3;
constexpr int64_t kGrain = 512;  // points a chunk

int LevelsFor(int64_t triangles) {
  int levels = 1;
  while (levels < kMostLevels && (triangles << (2 * levels)) < kFineTriangles) ++levels;
  return levels;
}

}  // namespace

TargetDistances DistancesToFit(const ControlMesh& fit, const Points3f& points) {
  const int levels = LevelsFor(fit.topology().triangle_count());
  const LimitMesh limit = BuildLimitMesh(fit.topology(), fit.tags(), levels);
  Points3d surface;
  ApplyStencils(limit.position, fit.vertices(), &surface);
  const TriangleBvh bvh(surface, limit.triangles);
  TargetDistances out;
  out.distance.resize(points.cols());
  out.triangle.resize(points.cols());
  ParallelFor(points.cols(), kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      const ClosestPoint closest = bvh.Closest(points.col(k).cast<double>());
      out.distance[k] = closest.distance;
      out.triangle[k] = closest.triangle >> (2 * levels);
    }
  });
  return out;
}

DistanceExtent Extent(const std::vector<double>& distances, int64_t left_out) {
  std::vector<double> sorted = distances;
  std::sort(sorted.begin(), sorted.end());
  const int64_t count = std::max<int64_t>(0, static_cast<int64_t>(sorted.size()) - left_out);
  DistanceExtent extent;
  if (count == 0) return extent;
  double squares = 0;
  for (int64_t k = 0; k < count; ++k) squares += sorted[k] * sorted[k];
  extent.rms = std::sqrt(squares / static_cast<double>(count));
  const auto beyond = static_cast<int64_t>(kFarthestShare * static_cast<double>(count));
  extent.most = sorted[count - 1 - beyond];
  extent.max = sorted[count - 1];
  return extent;
}

}  // namespace cagefit
