// Points that stand for a triangle mesh when it is measured.
#ifndef CAGEFIT_CORE_METRICS_SURFACE_SAMPLES_H_
#define CAGEFIT_CORE_METRICS_SURFACE_SAMPLES_H_

#include <cstdint>

#include "core/mesh/triangle_mesh.h"

namespace cagefit {

// The vertices that triangles use, in order, then `per_face` times the number of triangles points
// drawn uniformly by area. The same for one seed on every machine.
Points3d SampleSurface(const TriangleMesh& mesh, int per_face, uint64_t seed);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_METRICS_SURFACE_SAMPLES_H_
