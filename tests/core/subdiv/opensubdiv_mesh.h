// A control mesh as OpenSubdiv's refiner: scheme LOOP, boundary rule EDGE_ONLY, creases and corners
// of infinite sharpness. For the sources of the oracles alone: it includes OpenSubdiv.
#ifndef CAGEFIT_TESTS_CORE_SUBDIV_OPENSUBDIV_MESH_H_
#define CAGEFIT_TESTS_CORE_SUBDIV_OPENSUBDIV_MESH_H_

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>

#include "core/base/types.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::testing {

// Not refined yet.
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> OpenSubdivMesh(int32_t vertex_count,
                                                                 const Triangles& triangles,
                                                                 const CreaseTags& tags);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_SUBDIV_OPENSUBDIV_MESH_H_
