// OpenSubdiv's limit surface at any point, the oracle for LimitSurface: Bfr in double.
//
// Bfr isolates irregular features by adaptive refinement. Outside triangles of 2^-depth the size of
// the control triangle at extraordinary vertices its patches are box splines, exact to rounding;
// those last triangles are approximated.
#ifndef CAGEFIT_TESTS_CORE_SUBDIV_OPENSUBDIV_SURFACE_H_
#define CAGEFIT_TESTS_CORE_SUBDIV_OPENSUBDIV_SURFACE_H_

#include <vector>

#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"
#include "core/subdiv/surface_point.h"

namespace cagefit::testing {

// Position and derivatives at the points; quick if these are sorted by face. Depth 0 to 10.
std::vector<SurfaceJet> OpenSubdivSurface(const Topology& topology, const CreaseTags& tags,
                                          const Points3d& V,
                                          const std::vector<SurfacePoint>& points, int depth);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_SUBDIV_OPENSUBDIV_SURFACE_H_
