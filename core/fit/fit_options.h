// Settings of a fit. Lengths are in the user's units; energies are evaluated in normalised
// coordinates (normalization.h).
#ifndef CAGEFIT_CORE_FIT_FIT_OPTIONS_H_
#define CAGEFIT_CORE_FIT_FIT_OPTIONS_H_

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
  double radius_factor = 2.0;  // of the median distance to the 6th neighbour; 0.5 to 20
  double far_radius = 0;       // d0, user units; 0: three times the radius
};

struct ArapOptions {
  double weight = 0.01;  // alpha >= 0
  RestMesh rest = RestMesh::kTemplate;
};

struct SolverOptions {
  Solver solver = Solver::kGaussNewton;
  int max_iterations = 50;  // 1 to 10,000
  double relative_decrease =
      1e-3;  // stop when a step lowers the energy by less than this share; in (0, 1)
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
