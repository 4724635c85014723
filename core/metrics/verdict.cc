#include "core/metrics/verdict.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

// Beyond these a person would look at the frame.
constexpr double kSuspectUncovered = 0.02;
constexpr double kSuspectRmsPerMedian = 3;
constexpr double kSuspectLeastRms =
    1e-3;                             // of the diagonal: below it, no multiple of a median counts
constexpr double kSuspectRms = 1e-2;  // of the diagonal
constexpr double kSuspectFlipped = 0.01;
constexpr double kSuspectBare = 0.05;  // more than usual
// Beyond these the next frame must not start from this one.
constexpr double kLostUncovered = 0.25;
constexpr double kLostRms = 5e-2;  // of the diagonal
constexpr double kLostFlipped = 0.1;
constexpr int64_t kGrain = 512;  // samples a chunk

}  // namespace

SampledDistances SampleDistances(const PointCloud& target, const TriangleBvh& fit, int count,
                                 double cover_distance) {
  const int64_t points = target.size(), samples = std::min<int64_t>(count, points);
  SampledDistances out;
  out.samples = static_cast<int>(samples);
  int64_t uncovered = 0;
  double squares = 0;
  std::vector<double> distances(samples);
  ParallelFor(samples, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      distances[k] = fit.Closest(target.points.col(k * points / samples).cast<double>()).distance;
    }
  });
  for (const double d : distances) {
    out.mean += d;
    squares += d * d;
    out.max = std::max(out.max, d);
    uncovered += d > cover_distance;
  }
  const auto divisor = static_cast<double>(std::max<int64_t>(1, samples));
  out.mean /= divisor;
  out.rms = std::sqrt(squares / divisor);
  out.uncovered_share = static_cast<double>(uncovered) / divisor;
  return out;
}

Verdict Judge(const VerdictInput& input) {
  const double uncovered = input.distances.uncovered_share, rms = input.distances.rms;
  if (uncovered > kLostUncovered || rms > kLostRms * input.diagonal ||
      input.flipped_share > kLostFlipped) {
    return Verdict::kLost;
  }
  const bool much_worse = input.median_rms > 0 && rms > kSuspectRmsPerMedian * input.median_rms &&
                          rms > kSuspectLeastRms * input.diagonal;
  const bool is_bare = input.median_bare_share.has_value() &&
                       input.bare_share > *input.median_bare_share + kSuspectBare;
  if (is_bare || uncovered > kSuspectUncovered || much_worse ||
      rms > kSuspectRms * input.diagonal || input.flipped_share > kSuspectFlipped) {
    return Verdict::kSuspect;
  }
  return Verdict::kOk;
}

}  // namespace cagefit
