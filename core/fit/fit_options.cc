#include "core/fit/fit_options.h"

#include <cmath>

#include "core/base/check_range.h"
#include "core/base/status.h"

namespace cagefit {

FitOptions FitOptions::Paper() {
  FitOptions paper;
  paper.target = {/*remove_outliers=*/false, /*repair_normals=*/false};
  paper.distance.sampling = Sampling::kControlVertices;
  paper.distance.radius_share = std::sqrt(0.0005);
  paper.distance.first_radius = 1;
  paper.coverage.weight = 0;
  paper.boundary.weight = 0;
  paper.arap.weight = 0.01;
  paper.solver.solver = Solver::kAdam;
  paper.solver.max_iterations = 1000;
  paper.solver.first_stiffness = 1;
  return paper;
}

absl::Status FitOptions::Validate() const {
  RETURN_IF_ERROR(CheckRange("samples_per_triangle", distance.samples_per_triangle, 1, 100));
  RETURN_IF_ERROR(CheckRange("radius", distance.radius, 0, 1e12));
  RETURN_IF_ERROR(CheckRange("radius_share", distance.radius_share, 0, 1));
  RETURN_IF_ERROR(CheckRange("radius_factor", distance.radius_factor, 0.5, 20));
  RETURN_IF_ERROR(CheckRange("far_radius", distance.far_radius, 0, 1e12));
  if (distance.first_radius != 0) {
    RETURN_IF_ERROR(CheckRange("first_radius", distance.first_radius, 1, 64));
  }
  RETURN_IF_ERROR(CheckRange("kernel_scale", distance.kernel_scale, 0, 1e12));
  RETURN_IF_ERROR(CheckRange("coverage_weight", coverage.weight, 0, 1e6));
  RETURN_IF_ERROR(CheckRange("coverage_points_per_vertex", coverage.points_per_vertex, 1, 1000));
  RETURN_IF_ERROR(CheckRange("landmark_weight", landmarks.weight, 0, 1e6));
  RETURN_IF_ERROR(CheckRange("boundary_weight", boundary.weight, 0, 1e6));
  RETURN_IF_ERROR(CheckRange("arap_weight", arap.weight.value_or(0), 0, 1e6));
  RETURN_IF_ERROR(CheckRange("max_iterations", solver.max_iterations, 1, 100'000));
  RETURN_IF_ERROR(CheckRange("relative_decrease", solver.relative_decrease, 1e-12, 0.5));
  RETURN_IF_ERROR(CheckRange("first_stiffness", solver.first_stiffness, 1, 1e6));
  RETURN_IF_ERROR(CheckRange("learning_rate", solver.learning_rate, 1e-8, 1));
  RETURN_IF_ERROR(CheckRange("distance_weight", distance.weight, 0, 1e6));
  RETURN_IF_ERROR(image.Validate());
  if (image.views == Views::kNone) return absl::OkStatus();
  if (solver.solver == Solver::kCeres) {
    return absl::InvalidArgumentError(
        "solver is CERES, which does not take images; use GAUSS_NEWTON or ADAM");
  }
  if (image.mode == SilhouetteMode::kPytorch3d && solver.solver != Solver::kAdam) {
    return absl::InvalidArgumentError(
        "image.mode is PYTORCH3D, which has no Gauss-Newton rows; use solver ADAM");
  }
  return absl::OkStatus();
}

}  // namespace cagefit
