// Tags of a mesh for another mesh on the same positions.
#ifndef CAGEFIT_CORE_TEMPLATE_CARRY_TAGS_H_
#define CAGEFIT_CORE_TEMPLATE_CARRY_TAGS_H_

#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"

namespace cagefit {

// The creases and corners of `tags`, which name vertices at `from` (3 x N), as edges of `topology`
// and vertices at `to` (3 x n) of exactly the same positions. What `topology` does not have is left
// out; INVALID_ARGUMENT names a vertex outside [0, N).
absl::StatusOr<CreaseTags> CarryTags(const CreaseTags& tags, const Points3d& from,
                                     const Points3d& to, const Topology& topology);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_CARRY_TAGS_H_
