// Meshes and clouds in files: .ply .obj .stl .off .xyz .pcd .drc, told apart by name.
#ifndef CAGEFIT_CLIENT_IO_GEOMETRY_FILE_H_
#define CAGEFIT_CLIENT_IO_GEOMETRY_FILE_H_

#include <cstdint>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/cloud/point_cloud.h"
#include "core/mesh/control_mesh.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit::client {

// What a file held. Polygons are cut into fans of triangles; vertices keep the file's order and
// number.
struct Geometry {
  TriangleMesh mesh;     // triangles is 3 x 0 for a cloud
  Points3f normals;      // 3 x N per vertex, or 3 x 0 when the file has none
  int64_t polygons = 0;  // faces before they were cut
  CreaseTags tags;       // creases and corners of the vertices, which only .obj has

  bool is_cloud() const { return mesh.triangles.cols() == 0; }
};

struct ReadLimits {
  int64_t max_file_bytes = int64_t{2} << 30;
  int64_t max_vertices = 50'000'000;
  int64_t max_faces = 100'000'000;
};

// The end of the name from its last dot on, in lower case: ".ply".
std::string FileExtension(const std::string& path);
// True when the name ends with one of the formats above.
bool IsGeometryFile(const std::string& path);

// NOT_FOUND, INVALID_ARGUMENT or RESOURCE_EXHAUSTED; the message starts with the path and says what
// is wrong and where. Points that are not finite, and faces with indices out of range, are errors;
// a PLY, PCD or XYZ cloud may hold NaN points (depth cameras write them), which are dropped.
absl::StatusOr<Geometry> ReadGeometry(const std::string& path, const ReadLimits& limits = {});

// A fit's target: the cloud, or the vertices of the mesh with their normals (the file's, or
// angle-weighted).
PointCloud ToCloud(const Geometry& geometry);

// A control mesh: .obj (with crease edges and corners as written by WriteControlMesh) or any mesh
// format above.
absl::StatusOr<ControlMesh> ReadControlMesh(const std::string& path);

// Unit normals of a mesh's corners: of corner c of triangle t, column indices(c, t) of `values`.
// Empty: none.
struct CornerNormals {
  Points3d values;
  Triangles indices;
};

// .obj .ply .off .stl .drc by name. Normals go to .obj, and to .ply, which has one a vertex: the
// mean of its corners'. Whole or not at all: written beside and renamed.
absl::Status WriteMesh(const std::string& path, const TriangleMesh& mesh,
                       const CornerNormals& normals = {});
absl::Status WriteControlMesh(const std::string& path, const ControlMesh& mesh);
// .ply .xyz .drc by name.
absl::Status WriteCloud(const std::string& path, const PointCloud& cloud);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_GEOMETRY_FILE_H_
