// OpenSubdiv's Loop subdivision of a control mesh, the oracle for ours: scheme LOOP, boundary rule
// EDGE_ONLY, creases and corners of infinite sharpness, all in double.
#ifndef CAGEFIT_TESTS_CORE_SUBDIV_OPENSUBDIV_LOOP_H_
#define CAGEFIT_TESTS_CORE_SUBDIV_OPENSUBDIV_LOOP_H_

#include <memory>
#include <vector>

#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"

namespace cagefit::testing {

class OpenSubdivLoop {
 public:
  // Refines uniformly `depth` times, of which the first `levels` may be asked for. Levels above
  // that need no numbering of ours, which makes `depth` cheap. depth >= levels.
  OpenSubdivLoop(const Topology& topology, const CreaseTags& tags, int levels, int depth);
  ~OpenSubdivLoop();

  // Vertices of the mesh refined `level` times, numbered as Refinement::topology numbers them.
  Points3d Refined(const Points3d& V, int level) const;

  // Limits of the same vertices: refined on to `depth`, then Far's limit masks. Far has no mask for
  // darts and takes the smooth one, which is only as good as the mesh is fine.
  Points3d Limit(const Points3d& V, int level) const;

 private:
  struct Refiner;
  std::unique_ptr<Refiner> refiner_;
  std::vector<std::vector<int32_t>> numbers_;  // per level, OpenSubdiv's index of our vertex
};

// Limits of the vertices without any limit mask: refining the triangles around a vertex gives as
// many smaller triangles around it, whatever lies beyond them. Each round of OpenSubdiv's uniform
// refinement shrinks the star to less than 5/8, so that 80 leave nothing that a double can tell.
Points3d LimitByShrinkingStars(const Topology& topology, const CreaseTags& tags, const Points3d& V,
                               int rounds = 80);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_CORE_SUBDIV_OPENSUBDIV_LOOP_H_
