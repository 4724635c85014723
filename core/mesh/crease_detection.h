// Sharp features of a triangle mesh, found by dihedral angle.
#ifndef CAGEFIT_CORE_MESH_CREASE_DETECTION_H_
#define CAGEFIT_CORE_MESH_CREASE_DETECTION_H_

#include "core/base/types.h"
#include "core/mesh/control_mesh.h"
#include "core/mesh/topology.h"

namespace cagefit {

inline constexpr double kDefaultCreaseAngle = 40;  // degrees

// On what kind of surface creases are looked for.
enum class CreaseEffort {
  kOnParts,  // where the creases as a whole are a part's (below): bodies and scans have none
  kAlways
};

// Crease edges and corners of a mesh, for `angle` in degrees (0: none).
//
// The angle of an edge is that between the normals of its two triangles. An edge is a candidate
// when the surface turns in that edge and not beside it: its angle is most of the angle between the
// mean normals a few triangles away on either side, and several times what is usual around it, so
// that fillets, noise and coarsely tessellated round shapes have none. Candidates of at least
// `angle` are creases, and so are weaker ones that continue them without a sharp turn (hysteresis,
// down to a third of the angle). Of what hangs together, spurs are dropped, then what is shorter
// than a tenth of the bounding box's diagonal or has many loose ends and kinks for its length:
// parts have long smooth edges, folds of bodies and scans are ragged.
//
// Corners are vertices where three or more creases meet or where one turns by more than 50 degrees.
// Boundary edges are no creases but count where a crease ends at them. Edges come in the order of
// the topology, corners in that of the vertices.
CreaseTags DetectCreases(const Points3d& vertices, const Topology& topology, double angle,
                         CreaseEffort effort);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_MESH_CREASE_DETECTION_H_
