// Reads the test data's meshes, without the project's own readers, which are tested against the
// same files.
#ifndef CAGEFIT_TESTS_SUPPORT_MESH_FILE_H_
#define CAGEFIT_TESTS_SUPPORT_MESH_FILE_H_

#include <string>

#include "core/mesh/triangle_mesh.h"

namespace cagefit::testing {

// Binary little-endian PLY (float or double x, y, z; scalar vertex properties beside them; faces of
// three vertices) or OBJ (v and f lines, faces of three vertices), by the name's ending. `name` is
// relative to DataDir(). Throws std::runtime_error naming the file for anything else.
TriangleMesh ReadTestMesh(const std::string& name);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_MESH_FILE_H_
