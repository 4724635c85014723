// Settings of a fit. Lengths are in the user's units; energies are evaluated in normalised
// coordinates (normalization.h).
#ifndef CAGEFIT_CORE_FIT_FIT_OPTIONS_H_
#define CAGEFIT_CORE_FIT_FIT_OPTIONS_H_

#include <optional>

#include "absl/status/status.h"
#include "core/energy/field.h"
#include "core/energy/robust_kernel.h"
#include "core/fit/image_options.h"
#include "core/subdiv/surface_sampler.h"

namespace cagefit {

enum class Solver { kGaussNewton, kCeres, kAdam };
enum class RestMesh { kTemplate, kPreviousFrame };

struct DistanceOptions {
  double weight = 1;  // 0 to 1e6; 0: images alone, with coverage.weight 0
  Field field = Field::kImls;
  Sampling sampling = Sampling::kRefinedVertices;  // points that are held to the target
  int samples_per_triangle = 4;                    // with kArea; 1 to 100
  // h: `radius` (user units) where positive, else radius_share of the longest side of the first
  // target's box where positive, else radius_factor times the spacing of each frame, more where the
  // frame is noisy.
  double radius = 0;
  double radius_share = 0;     // 0 to 1
  double radius_factor = 1.7;  // of the median distance to the 6th neighbour; 0.5 to 20
  double far_radius = 0;       // d0, user units; 0: three times the radius
  // Coarse to fine: starts with this multiple of h and halves it step by step; 1 to 64, 1: always
  // h. 0: by the distance of the start from the target, onto which a start that is far off is moved
  // as a whole (alignment.h).
  double first_radius = 0;
  Kernel kernel = Kernel::kIdentity;  // rho, for distance and coverage alike
  double kernel_scale = 0;            // user units; 0: twice the noise estimate of each frame
};

// Data-to-model distance (energy/coverage_term.h).
struct CoverageOptions {
  double weight = 10;         // 0 to 1e6; 0: none, as in [xie2022]
  int points_per_vertex = 8;  // target points that take part, per control vertex (16,000 in all if
                              // that is more); 1 to 1,000
};

// Of the landmarks that a frame brings (energy/landmark_term.h).
struct LandmarkOptions {
  double weight = 1;  // delta, 0 to 1e6
};

// Of an open surface (energy/boundary_term.h).
struct BoundaryOptions {
  double weight = 0.1;  // eta, 0 to 1e6; 0: none
};

struct ArapOptions {
  // alpha >= 0. Not set: by the number of control vertices and the noise of the frame.
  std::optional<double> weight;
  RestMesh rest = RestMesh::kTemplate;
};
inline constexpr double kArapWeightPerVertex = 3e-6;

struct SolverOptions {
  Solver solver = Solver::kGaussNewton;
  int max_iterations = 50;          // 1 to 100,000
  double relative_decrease = 1e-2;  // stop when a step lowers the energy by less; up to 0.5
  // Gauss-Newton starts with alpha times this and lowers it step by step, so that parts which moved
  // as a whole are carried as a whole. 1 to 1e6; 1: no continuation.
  double first_stiffness = 400;
  double learning_rate = 1e-3;  // of Adam, unit coordinates a step; 1e-8 to 1
};

// What is done to a frame before it is fitted to.
struct TargetOptions {
  bool remove_outliers = true;  // cloud/outliers.h
  bool repair_normals = true;   // turn those that face against their neighbours
};

struct FitOptions {
  TargetOptions target;
  DistanceOptions distance;
  CoverageOptions coverage;
  ImageOptions image;
  LandmarkOptions landmarks;
  BoundaryOptions boundary;
  ArapOptions arap;
  SolverOptions solver;

  // The settings of [xie2022]: samples at control vertices, radius sqrt(0.0005) in the unit box,
  // alpha 0.01, rest mesh the template, Adam, no coverage, no boundary term, no changes to the
  // target.
  static FitOptions Paper();

  // INVALID_ARGUMENT naming the field, its value and its range.
  absl::Status Validate() const;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_FIT_OPTIONS_H_
