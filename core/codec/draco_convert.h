// Draco geometry as matrices and back. Internal to core/codec.
#ifndef CAGEFIT_CORE_CODEC_DRACO_CONVERT_H_
#define CAGEFIT_CORE_CODEC_DRACO_CONVERT_H_

#include <draco/compression/expert_encode.h>
#include <draco/point_cloud/point_cloud.h>

#include <string>

#include "absl/status/statusor.h"
#include "core/base/types.h"
#include "core/codec/draco_guard.h"
#include "core/codec/vertex_delta.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

// The values of all points of a 3-component attribute of any type, 3 x N, finite. `name` is for the
// error message.
absl::StatusOr<Points3f> ReadVectors3f(const draco::PointCloud& cloud,
                                       const draco::PointAttribute& attribute, const char* name);
absl::StatusOr<Points3d> ReadVectors3d(const draco::PointCloud& cloud,
                                       const draco::PointAttribute& attribute, const char* name);

// Positions of a decoded geometry; INVALID_ARGUMENT when it has none.
absl::StatusOr<const draco::PointAttribute*> PositionAttribute(const draco::PointCloud& cloud);

// Positions and, for a mesh, triangles.
absl::StatusOr<TriangleMesh> ToTriangleMesh(const GuardedGeometry& geometry);

// Adds `values` (3 x N, one column per point) and returns the attribute's number.
int AddAttribute(draco::GeometryAttribute::Type type, const Points3f& values,
                 draco::PointCloud* cloud);
int AddAttribute(draco::GeometryAttribute::Type type, const GridPoints& values,
                 draco::PointCloud* cloud);

// Runs the encoder. INTERNAL with Draco's words when it fails.
absl::StatusOr<std::string> EncodeToString(draco::ExpertEncoder* encoder);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CODEC_DRACO_CONVERT_H_
