#include "core/fit/ceres_solver.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "core/fit/ceres_costs.h"

namespace cagefit {

namespace {

// Ends the solve once the caller has lost interest.
class CancelCallback : public ceres::IterationCallback {
 public:
  explicit CancelCallback(const CancelFn& cancelled) : cancelled_(cancelled) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return IsCancelled(cancelled_) ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const CancelFn& cancelled_;
};

void AddCoverage(const CoverageTerm& coverage, Points3d* V, ceres::Problem* problem) {
  const int64_t n = V->cols();
  std::map<int32_t, double> stencil;
  for (int64_t k = 0; k < coverage.size(); ++k) {
    if (!coverage.is_used(k)) continue;
    const CoverageTerm::Row row = coverage.row(k);
    stencil.clear();
    for (const auto& [point, weight] : row.entries) {
      if (point < n) {
        stencil[point] += weight;
        continue;
      }
      for (StencilMatrix::InnerIterator s(coverage.surface().refinement(), point - n); s; ++s) {
        stencil[s.col()] += weight * s.value();
      }
    }
    std::vector<double*> blocks;
    std::vector<double> weights;
    for (const auto& [j, weight] : stencil) {
      blocks.push_back(V->col(j).data());
      weights.push_back(weight);
    }
    problem->AddResidualBlock(new CoverageCost(row, coverage.kernel(), std::move(weights)), nullptr,
                              blocks);
  }
}

void AddAttachments(const Objective& objective, Points3d* V, ceres::Problem* problem) {
  for (const Attachments* set : objective.attachments()) {
    for (int64_t k = 0; k < set->size(); ++k) {
      if (set->weights[k].isZero(0)) continue;
      std::vector<double*> blocks;
      std::vector<double> stencil;
      for (StencilMatrix::InnerIterator s(set->rows, k); s; ++s) {
        blocks.push_back(V->col(s.col()).data());
        stencil.push_back(s.value());
      }
      problem->AddResidualBlock(
          new AttachmentCost(set->weights[k], set->targets.col(k), std::move(stencil)), nullptr,
          blocks);
    }
  }
}

std::unique_ptr<ceres::Problem> BuildProblem(const Objective& objective, Points3d* V) {
  auto problem = std::make_unique<ceres::Problem>();
  std::vector<double*> blocks;
  const StencilMatrix& S = objective.stencils();
  for (int64_t i = 0; i < S.rows(); ++i) {
    blocks.clear();
    std::vector<double> stencil;
    for (StencilMatrix::InnerIterator s(S, i); s; ++s) {
      blocks.push_back(V->col(s.col()).data());
      stencil.push_back(s.value());
    }
    problem->AddResidualBlock(new SampleCost(objective.distance(), i, std::move(stencil)), nullptr,
                              blocks);
  }
  if (objective.coverage() != nullptr) AddCoverage(*objective.coverage(), V, problem.get());
  AddAttachments(objective, V, problem.get());
  if (objective.arap_weight() <= 0) return problem;
  const ArapTerm& arap = objective.arap();
  for (int32_t i = 0; i < arap.vertex_count(); ++i) {
    blocks.assign(1, V->col(i).data());
    for (int32_t e = arap.begin(i); e < arap.begin(i + 1); ++e) {
      blocks.push_back(V->col(arap.neighbor(e)).data());
    }
    problem->AddResidualBlock(new ArapCost(arap, i, objective.arap_weight()), nullptr, blocks);
  }
  return problem;
}

// Minimises under held radii and branches.
class HeldMinimizer {
 public:
  HeldMinimizer(const SolverOptions& options, const CancelFn& cancelled, Objective* objective)
      : options_(options), cancelled_(cancelled), callback_(cancelled), objective_(objective) {
    // Conjugate gradients beat the sparse Cholesky by a factor of twenty at 2,000 control vertices.
    ceres_.linear_solver_type = ceres::CGNR;
    ceres_.preconditioner_type = ceres::JACOBI;
    ceres_.max_linear_solver_iterations = 500;
    ceres_.function_tolerance = options.relative_decrease;
    ceres_.logging_type = ceres::SILENT;
    ceres_.callbacks.push_back(&callback_);
  }

  // From *V, where `energies` are those of the last choice; replaces both and adds to *iterations.
  absl::Status Minimize(Points3d* V, Energies* energies, int* iterations) {
    if (objective_->has_feet()) return FollowFeet(V, energies, iterations);
    RETURN_IF_ERROR(Solve(options_.max_iterations - *iterations, V, iterations));
    *energies = objective_->Evaluate(*V, nullptr);
    return absl::OkStatus();
  }

 private:
  // The first is Ceres' own. Small steps in a row end the search: a single one may be small because
  // of its trust region.
  static constexpr double kFirstTrustRegion = 1e4, kMostTrustRegion = 1e8;
  static constexpr int kSmallSteps = 3;

  // Held feet let the surface slide along itself for nothing, and their minimum may be far from any
  // of the distance. So they follow each step, and what counts is the energy after that.
  absl::Status FollowFeet(Points3d* V, Energies* energies, int* iterations) {
    double trust_region = kFirstTrustRegion;
    for (int small = 0; *iterations < options_.max_iterations && small < kSmallSteps;) {
      const Points3d before = *V;
      ceres_.initial_trust_region_radius = trust_region;
      RETURN_IF_ERROR(Solve(1, V, iterations));
      const double promised = energies->total() - objective_->Evaluate(*V, nullptr).total();
      const Energies tried = objective_->AssignFeet(*V, nullptr);
      const double decrease = energies->total() - tried.total();
      const bool accepted = decrease > 0;
      const double gain = accepted ? decrease : promised;
      small = gain <= options_.relative_decrease * energies->total() ? small + 1 : 0;
      if (decrease > 0.5 * promised) {
        trust_region = std::min(kMostTrustRegion, 3 * trust_region);
      } else if (decrease < 0.25 * promised) {
        trust_region /= 4;
      }
      if (!accepted) *V = before;
      *energies = accepted ? tried : objective_->AssignFeet(*V, nullptr);
    }
    return absl::OkStatus();
  }

  absl::Status Solve(int max_iterations, Points3d* V, int* iterations) {
    // The rows of coverage are others after each choice of feet.
    const std::unique_ptr<ceres::Problem> problem = BuildProblem(*objective_, V);
    ceres_.max_num_iterations = max_iterations;
    ceres::Solver::Summary summary;
    ceres::Solve(ceres_, problem.get(), &summary);
    if (IsCancelled(cancelled_)) return absl::CancelledError("fit: cancelled");
    if (!summary.IsSolutionUsable()) {
      return absl::InternalError(absl::StrCat("fit: diverged, ", summary.message));
    }
    // Iteration 0 is the evaluation of the start.
    *iterations += std::max<int>(1, static_cast<int>(summary.iterations.size()) - 1);
    return absl::OkStatus();
  }

  const SolverOptions& options_;
  const CancelFn& cancelled_;
  CancelCallback callback_;
  ceres::Solver::Options ceres_;
  Objective* objective_;
};

}  // namespace

absl::StatusOr<Minimization> MinimizeCeres(const SolverOptions& options, const CancelFn& cancelled,
                                           Objective* objective, Points3d* V) {
  Minimization out;
  out.initial = out.final = objective->Assign(*V, nullptr);
  HeldMinimizer minimizer(options, cancelled, objective);
  while (out.iterations < options.max_iterations && !out.converged) {
    if (IsCancelled(cancelled)) return absl::CancelledError("fit: cancelled");
    const double before = out.final.total();
    RETURN_IF_ERROR(minimizer.Minimize(V, &out.final, &out.iterations));
    out.final = objective->Assign(*V, nullptr);
    out.converged = std::abs(before - out.final.total()) <= options.relative_decrease * before;
  }
  return out;
}

}  // namespace cagefit
