#include "core/fit/fitter.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/status.h"
#include "core/fit/adam.h"
#include "core/fit/alignment.h"
#include "core/fit/ceres_solver.h"
#include "core/fit/frame_target.h"
#include "core/fit/gauss_newton.h"
#include "core/fit/objective.h"
#include "core/fit/step_system.h"
#include "core/subdiv/limit.h"
#include "core/subdiv/surface_projector.h"
#include "core/subdiv/surface_sampler.h"

namespace cagefit {

namespace {

// A field of four radii costs sixteen times as much; beyond it tangent planes serve.
constexpr double kMostFirstRadius = 4;
// Area sampling draws the same points for every session on one template.
constexpr uint64_t kSamplingSeed = 1;
constexpr double kSameSize = 0.1;  // of the logarithm
// Unit coordinates of what Evaluate takes: the search for the nearest point squares them as floats.
constexpr double kFarthest = 1e6;

absl::Status CheckVertices(const char* name, const Points3d& V, int64_t n) {
  if (V.cols() == n && V.allFinite()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s: %d vertices; %d finite ones are needed", name, V.cols(), n));
}

absl::Status CheckStarts(const std::vector<Points3d>& starts, int64_t n) {
  if (starts.empty()) return absl::InvalidArgumentError("starts: none");
  for (const Points3d& start : starts) RETURN_IF_ERROR(CheckVertices("start", start, n));
  return absl::OkStatus();
}

absl::Status CheckTarget(const PointCloud& target) {
  RETURN_IF_ERROR(ValidateTarget(target));
  if (target.has_normals()) return absl::OkStatus();
  return absl::InvalidArgumentError("target: it has no normals");
}

// Loose feet blur the energy, by their square, by less than what ends the solver.
double FootTolerance(const SolverOptions& options) {
  return std::clamp(0.1 * std::sqrt(options.relative_decrease), 1e-5, 1e-2);
}

Objective MakeObjective(const ControlMesh& mesh, StencilMatrix samples, const FitOptions& options,
                        double foot_tolerance) {
  const bool shows = options.image.views != Views::kNone;
  std::shared_ptr<const RefinedSurface> m1;
  OptionalTerms terms;
  if (options.coverage.weight > 0 || shows) {
    m1 = std::make_shared<RefinedSurface>(mesh.topology(), mesh.tags());
  }
  if (options.coverage.weight > 0) {
    terms.coverage =
        std::make_unique<CoverageTerm>(mesh.topology(), mesh.tags(), foot_tolerance, m1);
  }
  if (shows) {
    terms.images = std::make_unique<ImageTerm>(
        m1, RenderOptions(options.image), options.image.views_per_iteration, options.image.seed);
  }
  if (options.landmarks.weight > 0) {
    terms.landmarks = std::make_unique<LandmarkTerm>(mesh.topology(), mesh.tags());
  }
  if (options.boundary.weight > 0) {
    terms.boundary = std::make_unique<BoundaryTerm>(mesh.topology(), mesh.tags());
  }
  return Objective(mesh.topology(), std::move(samples), 0, std::move(terms));
}

// A closed surface has no boundary to be drawn, so none is sought in its frames.
FitOptions OptionsFor(const ControlMesh& mesh, FitOptions options) {
  if (mesh.topology().BoundaryLoops().empty()) options.boundary.weight = 0;
  return options;
}

}  // namespace

absl::StatusOr<StencilMatrix> FitSamples(const ControlMesh& template_mesh,
                                         const DistanceOptions& options) {
  return SampleStencils(template_mesh, options.sampling, options.samples_per_triangle,
                        kSamplingSeed);
}

struct Fitter::State {
  State(const ControlMesh& template_mesh, StencilMatrix samples, const Normalization& normalization,
        const FitOptions& options)
      : mesh(template_mesh),
        normalization(normalization),
        options(options),
        rest(normalization.ToUnit(mesh.vertices())),
        objective(MakeObjective(mesh, std::move(samples), options, FootTolerance(options.solver))),
        system(objective) {
    objective.SetRest(rest);
  }

  absl::Status Check(const FrameSource& source) const {
    if (source.landmarks == nullptr) return absl::OkStatus();
    return CheckLandmarks(*source.landmarks, mesh.vertex_count(), mesh.triangles().cols());
  }

  // Writes the start with the lowest energy, in unit coordinates, and returns its index.
  int Begin(const std::vector<Points3d>& starts, StartKind kind, Points3d* V) {
    int best = 0;
    double lowest = 0;
    SetRest(normalization.ToUnit(starts[0]), &objective);
    ObjectiveTarget geometry = frame.objective_target();
    geometry.images = nullptr;
    geometry.distance_weight = 1;  // for images alone, too: their own reach is a few pixels
    objective.SetTarget(geometry);
    objective.SetCoarseness(1, 1, /*is_coarse=*/true);  // some of the covered points tell enough
    for (size_t k = 0; k < starts.size(); ++k) {
      Points3d start = normalization.ToUnit(starts[k]);
      Energies energies = objective.AssignSamples(start, nullptr);
      double off = FarOff();
      if (kind == StartKind::kEarlierFit) {
        Points3d moved = AlignRigidly(SurfaceOf(start), frame.cloud()) * start;
        if (objective.AssignSamples(moved, nullptr).distance < energies.distance) {
          start.swap(moved);
          off = FarOff();
        } else {
          objective.AssignSamples(start, nullptr);
        }
      }
      // With coverage: a surface that was bent out of shape may lie on the target all the same.
      if (starts.size() > 1) energies = objective.AssignFeet(start, nullptr);
      if (k > 0 && !(energies.total() < lowest)) continue;
      lowest = energies.total();
      best = static_cast<int>(k);
      far_off = off;
      V->swap(start);
    }
    const bool is_automatic = options.distance.first_radius == 0;
    if (is_automatic && kind == StartKind::kTemplate &&
        far_off > kMostFirstRadius * frame.index().radius()) {
      Align(V);
    }
    objective.SetTarget(frame.objective_target());
    return best;
  }

  // How far from the target most samples are, where they were last assigned.
  double FarOff() const {
    std::vector<double> distances;
    for (const SampleResiduals& r : objective.residuals()) {
      distances.push_back(std::max(std::abs(r.f), r.beyond));
    }
    const auto rank = distances.begin() + static_cast<int64_t>(0.9 * (distances.size() - 1));
    std::nth_element(distances.begin(), rank, distances.end());
    return *rank;
  }

  TriangleMesh SurfaceOf(const Points3d& V) {
    if (alignment_mesh.triangles.cols() == 0) {
      alignment_mesh = BuildLimitMesh(mesh.topology(), mesh.tags(), 1);
    }
    TriangleMesh surface;
    ApplyStencils(alignment_mesh.position, V, &surface.vertices);
    surface.triangles = alignment_mesh.triangles;
    return surface;
  }

  void Align(Points3d* V) {
    const Similarity similarity = AlignToTarget(SurfaceOf(*V), frame.cloud());
    if (similarity.is_identity()) return;
    *V = similarity * *V;
    objective.AssignSamples(*V, nullptr);
    far_off = FarOff();
  }

  // How many radii the distance field has to reach at first so that most samples see the target
  // through it: a power of 2.
  double FirstRadius() const {
    if (options.distance.first_radius > 0) return options.distance.first_radius;
    double first = 1;
    while (first < kMostFirstRadius && first * frame.index().radius() < far_off) first *= 2;
    return first;
  }

  // Sets the rest mesh for a start V: in its size, where the two differ by more than a tenth.
  // Rotations start afresh, so that the result depends on nothing but the arguments.
  void SetRest(const Points3d& V, Objective* of) const {
    if (options.arap.rest == RestMesh::kPreviousFrame) return of->SetRest(V);
    const double ratio = MeanEdgeLength(mesh.topology(), V) / MeanEdgeLength(mesh.topology(), rest);
    of->SetRest(std::abs(std::log(ratio)) > kSameSize ? Points3d(ratio * rest) : rest);
  }

  // What Evaluate evaluates: its feet are exact, because a foot that is off by e puts an error of
  // the order of e into the gradient, while the solvers only mind that of e^2 in the energy.
  Objective& Loss() {
    if (loss == nullptr) {
      loss = std::make_unique<Objective>(
          MakeObjective(mesh, objective.stencils(), options, SurfaceProjector::kTolerance));
    }
    return *loss;
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
    return MinimizeGaussNewton(options.solver, cancelled, &objective, &system, V, FirstRadius());
  }

  ControlMesh mesh;
  Normalization normalization;
  FitOptions options;
  Points3d rest;  // of the template, unit coordinates
  Objective objective;
  StepSystem system;
  FrameTarget frame;
  bool has_frame = false;    // `frame` is that of the last fit
  double far_off = 0;        // of the chosen start, unit coordinates
  LimitMesh alignment_mesh;  // empty until a start is moved

  // Of Evaluate, and none of Fit's: empty until they are needed.
  std::unique_ptr<Objective> loss;
  std::unique_ptr<FrameTarget> loss_frame;
};

absl::StatusOr<Fitter> Fitter::Create(const ControlMesh& template_mesh,
                                      const Normalization& normalization,
                                      const FitOptions& options) {
  RETURN_IF_ERROR(options.Validate());
  ASSIGN_OR_RETURN(StencilMatrix samples, FitSamples(template_mesh, options.distance));
  return Fitter(std::make_unique<State>(template_mesh, std::move(samples), normalization,
                                        OptionsFor(template_mesh, options)));
}

Fitter::Fitter(std::unique_ptr<State> state) : state_(std::move(state)) {}
Fitter::~Fitter() = default;
Fitter::Fitter(Fitter&&) noexcept = default;
Fitter& Fitter::operator=(Fitter&&) noexcept = default;

absl::StatusOr<FitSummary> Fitter::Fit(const PointCloud& target,
                                       const std::vector<Points3d>& starts,
                                       const CancelFn& cancelled, const ClockFn& clock,
                                       Points3d* fitted, StartKind kind,
                                       const FrameSource& source) {
  State& s = *state_;
  RETURN_IF_ERROR(CheckStarts(starts, s.rest.cols()));
  RETURN_IF_ERROR(CheckTarget(target));
  RETURN_IF_ERROR(s.Check(source));
  const auto now = [&] { return clock ? clock() : 0.0; };

  const double t_start = now();
  s.has_frame = false;
  RETURN_IF_ERROR(s.frame.Build(target, s.normalization, s.options, s.rest.cols(), source));
  s.has_frame = true;
  s.objective.set_arap_weight(s.frame.ArapWeight(s.options, s.rest.cols()));
  const double t_indexed = now();

  Points3d V;
  const int chosen = s.Begin(starts, kind, &V);
  s.SetRest(V, &s.objective);
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
  const double scale = s.normalization.scale;
  const TargetIndex& index = s.frame.index();
  summary.radius = index.radius() / scale;
  summary.radius_in_spacings = index.radius() / index.spacing();
  summary.images = static_cast<int>(s.frame.objective_target().images->size());
  summary.noise = s.frame.noise() / scale;
  summary.outliers = s.frame.outliers();
  summary.grown_samples = static_cast<int>(s.objective.distance().grown_samples());
  summary.far_samples = static_cast<int>(s.objective.distance().far_samples());
  summary.samples = static_cast<int>(s.objective.stencils().rows());
  summary.index_ms = t_indexed - t_start;
  summary.solve_ms = now() - t_indexed;
  return summary;
}

absl::StatusOr<Energies> Fitter::Evaluate(const PointCloud* target, const Points3d& start,
                                          const Points3d& vertices, const CancelFn& cancelled,
                                          Points3d* gradient, const FrameSource& source) {
  State& s = *state_;
  const int64_t n = s.rest.cols();
  RETURN_IF_ERROR(CheckVertices("start", start, n));
  RETURN_IF_ERROR(CheckVertices("vertices", vertices, n));
  const Points3d V = s.normalization.ToUnit(vertices);
  if (V.cwiseAbs().maxCoeff() > kFarthest) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "vertices: one is %g times the first target's longest side away; at most %g are allowed",
        V.cwiseAbs().maxCoeff(), kFarthest));
  }
  const FrameTarget* frame = &s.frame;
  if (target != nullptr) {
    RETURN_IF_ERROR(CheckTarget(*target));
    RETURN_IF_ERROR(s.Check(source));
    if (s.loss_frame == nullptr) s.loss_frame = std::make_unique<FrameTarget>();
    RETURN_IF_ERROR(s.loss_frame->Build(*target, s.normalization, s.options, n, source));
    frame = s.loss_frame.get();
  } else if (!s.has_frame) {
    return absl::FailedPreconditionError("target: none is given and nothing was fitted to one");
  }
  if (IsCancelled(cancelled)) return absl::CancelledError("loss: cancelled");
  Objective& loss = s.Loss();
  loss.set_arap_weight(frame->ArapWeight(s.options, n));
  loss.SetTarget(frame->objective_target());
  s.SetRest(s.normalization.ToUnit(start), &loss);
  if (IsCancelled(cancelled)) return absl::CancelledError("loss: cancelled");
  const Energies energies = loss.Assign(V, gradient);
  // dE/dV_user = dV_unit/dV_user dE/dV_unit, and the objective gives half of that.
  if (gradient != nullptr) *gradient *= 2 * s.normalization.scale;
  return energies;
}

}  // namespace cagefit
