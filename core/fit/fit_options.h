// Settings of a fit. Lengths are in the user's units; energies are evaluated in normalised
// coordinates (normalization.h).
#ifndef CAGEFIT_CORE_FIT_FIT_OPTIONS_H_
#define CAGEFIT_CORE_FIT_FIT_OPTIONS_H_

#include <optional>

#include "absl/status/status.h"

namespace cagefit {

enum class Solver { kGaussNewton, kCeres };
enum class Sampling {
  kControlVertices,
  kRefinedVertices
};  // limit positions of M0's or of M1's vertices
enum class RestMesh { kTemplate, kPreviousFrame };

struct DistanceOptions {
  Sampling sampling = Sampling::kRefinedVertices;
  double radius = 0;           // h, user units; 0: radius_factor times the spacing of each frame
  double radius_factor = 1.7;  // of the median distance to the 6th neighbour; 0.5 to 20
  double far_radius = 0;       // d0, user units; 0: three times the radius
};

struct ArapOptions {
  // alpha >= 0. Not set: kArapWeightPerVertex times the number of control vertices, because E_dist
  // grows with that number at equal distances and E_reg does not.
  std::optional<double> weight;
  RestMesh rest = RestMesh::kTemplate;
};
inline constexpr double kArapWeightPerVertex = 1e-5;

struct SolverOptions {
  Solver solver = Solver::kGaussNewton;
  int max_iterations = 50;          // 1 to 10,000
  double relative_decrease = 1e-2;  // stop when a step lowers the energy by less; up to 0.5
  // Gauss-Newton starts with alpha times this and lowers it step by step, so that parts which moved
  // as a whole are carried as a whole. 1 to 1e6; 1: no continuation.
  double first_stiffness = 100;
};

struct FitOptions {
  DistanceOptions distance;
  ArapOptions arap;
  SolverOptions solver;

  // INVALID_ARGUMENT naming the field, its value and its range.
  absl::Status Validate() const;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_FIT_OPTIONS_H_
