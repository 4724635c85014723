// Points of the limit surface that stand for it.
#ifndef CAGEFIT_CORE_SUBDIV_SURFACE_SAMPLER_H_
#define CAGEFIT_CORE_SUBDIV_SURFACE_SAMPLER_H_

#include <vector>

#include "absl/status/statusor.h"
#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"
#include "core/subdiv/stencils.h"
#include "core/subdiv/surface_point.h"

namespace cagefit {

enum class Sampling {
  kControlVertices,  // limit positions of M0's vertices, as in [xie2022]
  kRefinedVertices,  // limit positions of M1's vertices
  kArea              // points drawn uniformly by area
};

// Every control vertex, in order.
std::vector<SurfacePoint> ControlVertexPoints(const Topology& topology);

// Every vertex of the mesh refined once, in its order (refine.h): control vertices, edges' middles.
std::vector<SurfacePoint> RefinedVertexPoints(const Topology& topology);

// samples_per_triangle times the triangles, uniform by the area of the limit mesh of two
// refinements at control vertices V (3 x n). Stratified: points are equal steps of the running sum
// of the areas apart, in the order of the triangles, so that each of these gets its share rounded
// up or down, and uniform within its triangle of that mesh. The same for the same seed.
// INVALID_ARGUMENT: no sample per triangle or no area.
absl::StatusOr<std::vector<SurfacePoint>> AreaPoints(const Topology& topology,
                                                     const CreaseTags& tags, const Points3d& V,
                                                     int samples_per_triangle, uint64_t seed);

// Rows over the control vertices of the points of a sampling. The mesh's vertices,
// samples_per_triangle and seed matter to kArea alone.
absl::StatusOr<StencilMatrix> SampleStencils(const ControlMesh& mesh, Sampling sampling,
                                             int samples_per_triangle, uint64_t seed);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_SURFACE_SAMPLER_H_
