#include "server/session/surface_export.h"

#include <new>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/codec/draco_codec.h"
#include "core/subdiv/refine.h"
#include "server/session/error_detail.h"

namespace cagefit::server {

absl::StatusOr<std::string> ExportSurface(const ControlMesh& mesh,
                                          const SurfaceExportOptions& options) {
  if (options.levels > 5) {
    return InvalidField("levels", absl::StrCat(options.levels), "expected 0 to 5");
  }
  if (options.position_bits != 0 && (options.position_bits < 8 || options.position_bits > 30)) {
    return InvalidField("position_bits", absl::StrCat(options.position_bits), "expected 8 to 30");
  }
  const int64_t triangles = int64_t{mesh.topology().triangle_count()} << (2 * options.levels);
  if (triangles > options.max_triangles) {
    return LimitExceeded("triangles of the refined surface", triangles, options.max_triangles);
  }
  try {
    LimitMesh limit =
        BuildLimitMesh(mesh.topology(), mesh.tags(), static_cast<int>(options.levels));
    TriangleMesh surface;
    ApplyStencils(limit.position, mesh.vertices(), &surface.vertices);
    surface.triangles = std::move(limit.triangles);
    DracoMeshOptions draco;
    draco.position_bits = static_cast<int>(options.position_bits);
    return EncodeDracoMesh(surface, draco);
  } catch (const std::bad_alloc&) {
    return WithDetail(
        absl::ResourceExhaustedError("the server has no memory left to refine this surface"),
        {"LIMIT_EXCEEDED", "memory", "", "", absl::Seconds(1)});
  }
}

}  // namespace cagefit::server
