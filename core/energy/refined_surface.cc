#include "core/energy/refined_surface.h"

#include "core/subdiv/limit.h"
#include "core/subdiv/refine.h"

namespace cagefit {

RefinedSurface::RefinedSurface(const Topology& control, const CreaseTags& tags)
    : topology(RefineOnce(control, tags).topology),
      position(BuildLimitMesh(control, tags, 1).position),
      transposed(position.transpose()) {}

}  // namespace cagefit
