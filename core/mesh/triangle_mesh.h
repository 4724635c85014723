// A triangle mesh as it comes from a file or a decoder: nothing is promised about its topology.
#ifndef CAGEFIT_CORE_MESH_TRIANGLE_MESH_H_
#define CAGEFIT_CORE_MESH_TRIANGLE_MESH_H_

#include "core/base/types.h"

namespace cagefit {

struct TriangleMesh {
  Points3d vertices;
  Triangles triangles;
};

// Unit vertex normals, each the angle-weighted mean of the adjacent face normals [thurmer1998]. A
// vertex without a face of positive area gets (0, 0, 0).
Points3d VertexNormals(const TriangleMesh& mesh);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_MESH_TRIANGLE_MESH_H_
