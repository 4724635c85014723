#include "core/fit/fitter.h"

#include <optional>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/parallel.h"
#include "core/base/status.h"
#include "core/fit/adam.h"
#include "core/fit/ceres_solver.h"
#include "core/fit/gauss_newton.h"
#include "core/fit/objective.h"
#include "core/fit/step_system.h"
#include "core/subdiv/limit.h"

namespace cagefit {

namespace {

// Default far radius as a multiple of the radius h: far enough for the field to stay smooth around
// the cloud, near enough that the rim of an open surface cannot wander.
constexpr double kFarRadiusPerRadius = 3;

StencilMatrix SampleStencils(const ControlMesh& mesh, Sampling sampling) {
  const int levels = sampling == Sampling::kControlVertices ? 0 : 1;
  return BuildLimitMesh(mesh.topology(), mesh.tags(), levels).position;
}

absl::Status CheckStarts(const std::vector<Points3d>& starts, int64_t n) {
  if (starts.empty()) return absl::InvalidArgumentError("starts: none");
  for (const Points3d& start : starts) {
    if (start.cols() == n && start.allFinite()) continue;
    return absl::InvalidArgumentError(
        absl::StrFormat("start: %d vertices; %d finite ones are needed", start.cols(), n));
  }
  return absl::OkStatus();
}

void ToUnit(const Normalization& normalization, const PointCloud& user, PointCloud* unit) {
  unit->points.resize(3, user.size());
  ParallelFor(user.size(), 16384, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      unit->points.col(i) =
          ((user.points.col(i).cast<double>() - normalization.center) * normalization.scale)
              .cast<float>();
    }
  });
  unit->normals = user.normals;
}

}  // namespace

struct Fitter::State {
  State(const ControlMesh& mesh, const Normalization& normalization, const FitOptions& options)
      : normalization(normalization),
        options(options),
        rest(normalization.ToUnit(mesh.vertices())),
        objective(mesh.topology(), SampleStencils(mesh, options.distance.sampling),
                  options.arap.weight.value_or(kArapWeightPerVertex * mesh.vertex_count()),
                  options.coverage.weight > 0
                      ? std::make_unique<CoverageTerm>(mesh.topology(), mesh.tags())
                      : nullptr),
        system(objective) {
    objective.SetRest(rest);
  }

  // Writes the start with the lowest E_dist, in unit coordinates, and returns its index.
  int Begin(const std::vector<Points3d>& starts, Points3d* V) {
    int best = 0;
    double lowest = 0;
    for (size_t k = 0; k < starts.size(); ++k) {
      Points3d start = normalization.ToUnit(starts[k]);
      objective.SetTarget(&index, target.far_radius);
      if (starts.size() > 1) {
        const double energy = objective.Assign(start, &half_gradient).distance;
        if (k > 0 && !(energy < lowest)) continue;
        lowest = energy;
      }
      best = static_cast<int>(k);
      V->swap(start);
    }
    objective.SetTarget(target);
    return best;
  }

  absl::StatusOr<Minimization> Minimize(const CancelFn& cancelled, Points3d* V) {
    switch (options.solver.solver) {
      case Solver::kCeres:
        return MinimizeCeres(options.solver, cancelled, &objective, V);
      case Solver::kAdam:
        return MinimizeAdam(options.solver, cancelled, &objective, V);
      case Solver::kGaussNewton:
        break;
    }
    return MinimizeGaussNewton(options.solver, cancelled, &objective, &system, V);
  }

  Normalization normalization;
  FitOptions options;
  Points3d rest;  // of the template, unit coordinates
  Objective objective;
  StepSystem system;
  PointCloud cloud;  // the frame's, unit coordinates
  TargetIndex index;
  ObjectiveTarget target;  // the frame's
  Points3d half_gradient;  // work space
};

absl::StatusOr<Fitter> Fitter::Create(const ControlMesh& template_mesh,
                                      const Normalization& normalization,
                                      const FitOptions& options) {
  RETURN_IF_ERROR(options.Validate());
  return Fitter(std::make_unique<State>(template_mesh, normalization, options));
}

Fitter::Fitter(std::unique_ptr<State> state) : state_(std::move(state)) {}
Fitter::~Fitter() = default;
Fitter::Fitter(Fitter&&) noexcept = default;
Fitter& Fitter::operator=(Fitter&&) noexcept = default;

absl::StatusOr<FitSummary> Fitter::Fit(const PointCloud& target,
                                       const std::vector<Points3d>& starts,
                                       const CancelFn& cancelled, const ClockFn& clock,
                                       Points3d* fitted) {
  State& s = *state_;
  RETURN_IF_ERROR(CheckStarts(starts, s.rest.cols()));
  RETURN_IF_ERROR(ValidateTarget(target));
  if (!target.has_normals()) return absl::InvalidArgumentError("target: it has no normals");
  const auto now = [&] { return clock ? clock() : 0.0; };

  const double t_start = now();
  ToUnit(s.normalization, target, &s.cloud);
  const double scale = s.normalization.scale;
  const DistanceOptions& distance = s.options.distance;
  const double radius = distance.radius > 0 ? distance.radius * scale : distance.radius_share;
  RETURN_IF_ERROR(s.index.Build(s.cloud, radius, distance.radius_factor));
  s.target.index = &s.index;
  s.target.far_radius = distance.far_radius > 0 ? distance.far_radius * scale
                                                : kFarRadiusPerRadius * s.index.radius();
  s.target.kernel = {distance.kernel, distance.kernel_scale * scale};
  s.target.cloud = &s.cloud;
  s.target.coverage_points = s.options.coverage.points_per_vertex * s.rest.cols();
  s.target.coverage_weight = s.options.coverage.weight;
  const double t_indexed = now();

  Points3d V;
  const int chosen = s.Begin(starts, &V);
  // Rotations, too, start afresh, so that the result depends on nothing but the arguments.
  s.objective.SetRest(s.options.arap.rest == RestMesh::kPreviousFrame ? V : s.rest);
  ASSIGN_OR_RETURN(const Minimization result, s.Minimize(cancelled, &V));
  if (!V.allFinite() || !std::isfinite(result.final.total())) {
    return absl::InternalError("fit: diverged, the control vertices are not finite");
  }
  *fitted = s.normalization.ToUser(V);

  FitSummary summary;
  summary.start = chosen;
  summary.initial = result.initial;
  summary.final = result.final;
  summary.iterations = result.iterations;
  summary.converged = result.converged;
  summary.radius = s.index.radius() / scale;
  summary.radius_in_spacings = s.index.radius() / s.index.spacing();
  summary.grown_samples = static_cast<int>(s.objective.distance().grown_samples());
  summary.far_samples = static_cast<int>(s.objective.distance().far_samples());
  summary.index_ms = t_indexed - t_start;
  summary.solve_ms = now() - t_indexed;
  return summary;
}

}  // namespace cagefit
