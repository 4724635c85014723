// Small meshes with known shape for tests that need no data. All are consistently oriented; closed
// ones have their triangles counter-clockwise from outside.
#ifndef CAGEFIT_TESTS_SUPPORT_SHAPES_H_
#define CAGEFIT_TESTS_SUPPORT_SHAPES_H_

#include <cstdint>

#include "core/mesh/triangle_mesh.h"

namespace cagefit::testing {

// Icosahedron split `levels` times, vertices on a sphere around the origin: 10 * 4^levels + 2.
TriangleMesh Icosphere(int levels, double radius = 1);

// Unit square in z = 0 seen from +z, `cells` x `cells` cells of two triangles. Two of its corners
// have one triangle (valence 2).
TriangleMesh OpenGrid(int cells);

// Disk of `radius` in z = 0 seen from +z: a centre of valence 6 and `rings` rings of 6, 12, 18, ...
// vertices.
TriangleMesh OpenDisk(int rings, double radius = 1);

// Torus around the z axis.
TriangleMesh Torus(int around, int across, double major_radius = 1, double minor_radius = 0.25);

// Cylinder barrel around the z axis from z = 0 to `length`, open at both ends: two boundary loops.
TriangleMesh Tube(int around, int along, double radius = 1, double length = 2);

// Two vertices of valence `around` (3 or more), 0 and 1, above and below a ring of valence 4.
TriangleMesh Bipyramid(int around);

// Surface of the cube [0, 1]^3, each face an OpenGrid of `cells` x `cells`.
TriangleMesh Cube(int cells);

// Closed cylinder around the z axis from z = 0 to `length`: two OpenDisks of `rings` and a barrel
// of 6 * rings vertices around, 2 * rings cells along.
TriangleMesh Drum(int rings, double radius = 1, double length = 2);

// Closed genus-0 mesh of 162 vertices whose valences cover 3 to 12: an icosphere with edges flipped
// at random and its vertices moved a little.
TriangleMesh MixedValences(uint32_t seed = 1);

// Closed genus-0 mesh of 642 vertices whose valences cover 3 to 20, by flips on a sphere around the
// origin, onto which it projects without overlap. Vertices 0 to 13 have valences 7 to 20 and form a
// strip of triangles: each touches two to four others.
TriangleMesh TouchingHubs();

// Puts `b` beside `a` without joining anything.
TriangleMesh Together(const TriangleMesh& a, const TriangleMesh& b);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_SHAPES_H_
