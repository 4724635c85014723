#include "core/fit/ceres_solver.h"

#include <ceres/ceres.h>

#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
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

}  // namespace

absl::StatusOr<Minimization> MinimizeCeres(const SolverOptions& options, const CancelFn& cancelled,
                                           Objective* objective, Points3d* V) {
  Minimization out;
  Points3d half_gradient;
  Energies energies = objective->Assign(*V, &half_gradient);
  out.initial = out.final = energies;
  CancelCallback cancel(cancelled);
  ceres::Solver::Options ceres_options;
  // Conjugate gradients beat the sparse Cholesky by a factor of twenty at 2,000 control vertices.
  ceres_options.linear_solver_type = ceres::CGNR;
  ceres_options.preconditioner_type = ceres::JACOBI;
  ceres_options.max_linear_solver_iterations = 500;
  ceres_options.function_tolerance = options.relative_decrease;
  ceres_options.logging_type = ceres::SILENT;
  ceres_options.callbacks.push_back(&cancel);
  while (out.iterations < options.max_iterations && !out.converged) {
    if (IsCancelled(cancelled)) return absl::CancelledError("fit: cancelled");
    ceres_options.max_num_iterations = options.max_iterations - out.iterations;
    // The rows of coverage are others after each choice of feet.
    const std::unique_ptr<ceres::Problem> problem = BuildProblem(*objective, V);
    ceres::Solver::Summary summary;
    ceres::Solve(ceres_options, problem.get(), &summary);
    if (IsCancelled(cancelled)) return absl::CancelledError("fit: cancelled");
    if (!summary.IsSolutionUsable()) {
      return absl::InternalError(absl::StrCat("fit: diverged, ", summary.message));
    }
    // Iteration 0 is the evaluation of the start.
    out.iterations += std::max<int>(1, static_cast<int>(summary.iterations.size()) - 1);
    const Energies before = energies;
    objective->Evaluate(*V, &half_gradient);
    energies = objective->Assign(*V, &half_gradient);
    out.converged =
        std::abs(before.total() - energies.total()) <= options.relative_decrease * before.total();
    out.final = energies;
  }
  return out;
}

}  // namespace cagefit
