// Tolerance mode: as many control vertices as a target needs, where it needs them.
#ifndef CAGEFIT_CORE_FIT_TOLERANCE_FIT_H_
#define CAGEFIT_CORE_FIT_TOLERANCE_FIT_H_

#include <cstdint>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/cancel.h"
#include "core/cloud/point_cloud.h"
#include "core/fit/fit_options.h"
#include "core/fit/fitter.h"
#include "core/fit/target_distances.h"
#include "core/mesh/control_mesh.h"

namespace cagefit {

struct ToleranceOptions {
  double tolerance = 1e-3;  // share of the diagonal of the target's box; 1e-6 to 0.1
  // Control vertices at most; 0: half as many as the target has points, beyond which a fit follows
  // single points.
  int32_t max_vertices = 0;

  // INVALID_ARGUMENT naming the field, its value and its range.
  absl::Status Validate() const;
};

// What max_vertices 0 stands for.
int32_t MostToleranceVertices(int64_t target_points);

enum class ToleranceEnd {
  kWithin,       // all target points but the farthest kFarthestShare are within tolerance
  kVertexLimit,  // max_vertices did not suffice
  kNoFurther     // more vertices no longer help: noise, or a start that lacks a part of the target
};

// A session whose template is `mesh` and whose first frame is the target fits it as well as
// `distances` says: Fitter::Fit from there gives `fitted`, bit for bit.
struct ToleranceFit {
  explicit ToleranceFit(ControlMesh start) : mesh(std::move(start)) {}

  ControlMesh mesh;  // start and rest shape of the last fit
  Points3d fitted;   // its control vertices after it, user units
  ToleranceEnd end = ToleranceEnd::kWithin;
  int rounds = 0;  // fits that it took; those that did not help count
  // Target to fit, user units. As many of the farthest points as the fit left out do not count.
  DistanceExtent distances;
};

// Fits `start`, splits edges where the target is beyond tolerance (subdiv/edge_split.h; creases and
// boundaries stay), and fits again, until it is within. Arguments and errors as Fitter's; the
// target's box gives the normalisation. A pure function of its arguments.
absl::StatusOr<ToleranceFit> FitToTolerance(const ControlMesh& start, const PointCloud& target,
                                            const ToleranceOptions& tolerance,
                                            const FitOptions& options, const CancelFn& cancelled);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_TOLERANCE_FIT_H_
