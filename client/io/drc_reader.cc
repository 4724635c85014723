#include <algorithm>
#include <utility>

#include "client/io/format_readers.h"
#include "core/base/status.h"
#include "core/codec/draco_codec.h"

namespace cagefit::client {

absl::StatusOr<Geometry> ReadDrc(absl::string_view bytes, const ReadLimits& limits) {
  DecodeLimits decode;
  decode.max_points = limits.max_vertices;
  decode.max_faces = limits.max_faces;
  decode.allow_metadata = true;
  Geometry geometry;
  ASSIGN_OR_RETURN(geometry.mesh, DecodeDracoMesh(bytes, decode, &geometry.normals));
  if (geometry.mesh.vertices.cols() == 0) return absl::InvalidArgumentError("no vertices in it");
  geometry.polygons = geometry.mesh.triangles.cols();
  return geometry;
}

}  // namespace cagefit::client
