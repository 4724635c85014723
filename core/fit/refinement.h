// Where a control mesh needs more vertices.
#ifndef CAGEFIT_CORE_FIT_REFINEMENT_H_
#define CAGEFIT_CORE_FIT_REFINEMENT_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/types/span.h"
#include "core/fit/target_distances.h"
#include "core/mesh/control_mesh.h"

namespace cagefit {

struct RefinementLimits {
  double tolerance = 0;      // target points beyond it ask for vertices
  double ignore_beyond = 0;  // and those beyond this do not: outliers
  double least_length = 0;   // edges no longer than this are not split
  int32_t vertices = 0;      // new ones at most
};

// The long edges of the triangles that points beyond tolerance lie over, those with the most such
// points first, until there are enough. Sorted; empty when none may be split.
std::vector<int32_t> EdgesToSplit(const ControlMesh& fit, const TargetDistances& distances,
                                  const RefinementLimits& limits);

// The mesh with these edges split (subdiv/edge_split.h) and its triangles evened out: local splits
// alone leave uneven triangles, of which thin parts are lost. One step
// of relaxation; more of them flatten thin parts. Fails where SplitEdges does.
absl::StatusOr<ControlMesh> SplitAndRelax(const ControlMesh& mesh, absl::Span<const int32_t> edges);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_REFINEMENT_H_
