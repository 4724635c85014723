// Control meshes for the tests of subdivision: every rule, boundary and valence, no data needed.
#ifndef CAGEFIT_TESTS_CORE_SUBDIV_SUBDIV_SAMPLES_H_
#define CAGEFIT_TESTS_CORE_SUBDIV_SUBDIV_SAMPLES_H_

#include <string>
#include <vector>

#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"
#include "core/mesh/triangle_mesh.h"
#include "core/subdiv/sharp_features.h"

namespace cagefit::testing {

struct SubdivSample {
  std::string name;
  Points3d V;
  Topology topology;
  CreaseTags tags;
};

Topology TopologyOf(const TriangleMesh& mesh);

// Closed and open shapes, moved off their planes at random, without tags and with creases (closed,
// open, ending on a boundary, meeting), corners and darts of all valences from 3 to 12.
std::vector<SubdivSample> SubdivSamples();

// Vertices where exactly one sharp edge ends.
std::vector<int32_t> Darts(const Topology& topology, const CreaseTags& tags);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_SUBDIV_SUBDIV_SAMPLES_H_
