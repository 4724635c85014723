#include "core/fit/tolerance_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/cloud/kd_tree.h"
#include "core/cloud/spacing.h"
#include "core/fit/normalization.h"
#include "core/fit/refinement.h"

namespace cagefit {

namespace {

constexpr double kGrowth = 0.4;      // new vertices of a round, per vertex
constexpr int32_t kLeastGrowth = 8;  // so that a tiny start grows, too
// The triangles of a small mesh are uneven for a round or two before they pay.
constexpr int kMaxRoundsInVain = 3;
// A smooth surface comes closer with the square of the number of vertices, one with edges at least
// in proportion. A round helps when it gains more than this power of its growth, and more than
// chance gives a round of few vertices.
constexpr double kLeastOrder = 0.25;
constexpr double kLeastGain = 0.97;
// Edges below this multiple of the points' spacing stand for noise.
constexpr double kLeastEdgePerSpacing = 0.5;

// The state after one fit.
struct Round {
  explicit Round(ControlMesh mesh) : fit(std::move(mesh)) {}

  ToleranceFit fit;
  TargetDistances distances;
  double ignore_beyond = 0;  // outliers are farther
  int64_t beyond = 0;        // points that count and are beyond tolerance
};

class Refiner {
 public:
  Refiner(const PointCloud& target, double tolerance, int32_t max_vertices,
          const FitOptions& options, const CancelFn& cancelled)
      : target_(target),
        tolerance_(tolerance),
        max_vertices_(max_vertices),
        options_(options),
        cancelled_(cancelled),
        least_length_(kLeastEdgePerSpacing * MedianSpacing(target.points, KdTree(target.points))) {}

  absl::StatusOr<Round> Fit(ControlMesh mesh) const {
    ASSIGN_OR_RETURN(const Normalization normalization,
                     Normalization::FromBox(BoundingBox(target_.points)));
    ASSIGN_OR_RETURN(Fitter fitter, Fitter::Create(mesh, normalization, options_));
    Round round(std::move(mesh));
    ASSIGN_OR_RETURN(const FitSummary summary, fitter.Fit(target_, {round.fit.mesh.vertices()},
                                                          cancelled_, nullptr, &round.fit.fitted));
    round.distances = DistancesToFit(Fitted(round), target_.points);
    round.fit.distances = Extent(round.distances.distance, summary.outliers);
    round.ignore_beyond = round.fit.distances.max;
    for (const double d : round.distances.distance) {
      round.beyond += d > tolerance_ && d <= round.ignore_beyond;
    }
    return round;
  }

  // The mesh of the next round; no more vertices than the last one where none may be added.
  absl::StatusOr<ControlMesh> Refine(const Round& round) const {
    const int32_t n = round.fit.mesh.vertex_count();
    RefinementLimits limits;
    limits.tolerance = tolerance_;
    limits.ignore_beyond = round.ignore_beyond;
    limits.least_length = least_length_;
    limits.vertices =
        std::min(std::max(kLeastGrowth, static_cast<int32_t>(kGrowth * n)), max_vertices_ - n);
    const ControlMesh fitted = Fitted(round);
    return SplitAndRelax(fitted, EdgesToSplit(fitted, round.distances, limits));
  }

  bool IsWithin(const Round& round) const { return round.fit.distances.most <= tolerance_; }
  bool IsFull(const Round& round) const { return round.fit.mesh.vertex_count() >= max_vertices_; }

  static bool Helped(const Round& before, const Round& after) {
    const double growth = static_cast<double>(after.fit.mesh.vertex_count()) /
                          static_cast<double>(before.fit.mesh.vertex_count());
    const double gain = std::min(kLeastGain, std::pow(growth, -kLeastOrder));
    return after.fit.distances.most < gain * before.fit.distances.most ||
           static_cast<double>(after.beyond) < gain * static_cast<double>(before.beyond);
  }

 private:
  static ControlMesh Fitted(const Round& round) {
    return round.fit.mesh.WithVertices(round.fit.fitted);
  }

  const PointCloud& target_;
  const double tolerance_;  // user units
  const int32_t max_vertices_;
  const FitOptions& options_;
  const CancelFn& cancelled_;
  const double least_length_;
};

}  // namespace

absl::Status ToleranceOptions::Validate() const {
  if (!(tolerance >= 1e-6 && tolerance <= 0.1)) {  // refuses NaN, too
    return absl::InvalidArgumentError(
        absl::StrFormat("tolerance is %g; it must be from 1e-06 to 0.1", tolerance));
  }
  if (max_vertices >= 0) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("max_vertices is %d; it must be from 0", max_vertices));
}

int32_t MostToleranceVertices(int64_t target_points) {
  return static_cast<int32_t>(
      std::min<int64_t>(target_points / 2, std::numeric_limits<int32_t>::max()));
}

absl::StatusOr<ToleranceFit> FitToTolerance(const ControlMesh& start, const PointCloud& target,
                                            const ToleranceOptions& tolerance,
                                            const FitOptions& options, const CancelFn& cancelled) {
  RETURN_IF_ERROR(tolerance.Validate());
  RETURN_IF_ERROR(ValidateTarget(target));
  const int32_t most =
      tolerance.max_vertices > 0 ? tolerance.max_vertices : MostToleranceVertices(target.size());
  const Refiner refiner(target, tolerance.tolerance * BoundingBox(target.points).diagonal(), most,
                        options, cancelled);

  ASSIGN_OR_RETURN(Round best, refiner.Fit(start));  // the last round that helped
  Round last = best;
  int rounds = 1, in_vain = 0;
  const auto finish = [&rounds](Round* round, ToleranceEnd end) {
    round->fit.end = end;
    round->fit.rounds = rounds;
    return std::move(round->fit);
  };
  while (!refiner.IsWithin(last)) {
    if (refiner.IsFull(last)) return finish(&last, ToleranceEnd::kVertexLimit);
    ASSIGN_OR_RETURN(ControlMesh mesh, refiner.Refine(last));
    if (mesh.vertex_count() == last.fit.mesh.vertex_count()) {
      return finish(&best, ToleranceEnd::kNoFurther);
    }
    ASSIGN_OR_RETURN(Round next, refiner.Fit(std::move(mesh)));
    ++rounds;
    in_vain = Refiner::Helped(last, next) ? 0 : in_vain + 1;
    last = std::move(next);
    if (in_vain == 0) best = last;
    if (in_vain == kMaxRoundsInVain && !refiner.IsWithin(last)) {
      return finish(&best, ToleranceEnd::kNoFurther);
    }
  }
  return finish(&last, ToleranceEnd::kWithin);
}

}  // namespace cagefit
