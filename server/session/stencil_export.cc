#include "server/session/stencil_export.h"

#include <new>
#include <utility>

#include "absl/strings/str_cat.h"
#include "core/base/status.h"
#include "core/fit/fitter.h"
#include "core/subdiv/limit.h"
#include "server/session/error_detail.h"

namespace cagefit::server {
namespace {

absl::StatusOr<ExportedStencils> Build(const ControlMesh& mesh, const DistanceOptions& distance,
                                       const StencilExportOptions& options) {
  ExportedStencils out;
  if (!options.levels.has_value()) {
    ASSIGN_OR_RETURN(out.S, FitSamples(mesh, distance));
    return out;
  }
  LimitMesh limit = BuildLimitMesh(mesh.topology(), mesh.tags(), static_cast<int>(*options.levels));
  out.S = std::move(limit.position);
  out.triangles = std::move(limit.triangles);
  return out;
}

}  // namespace

absl::StatusOr<ExportedStencils> ExportStencils(const ControlMesh& mesh,
                                                const DistanceOptions& distance,
                                                const StencilExportOptions& options) {
  if (options.levels.value_or(0) > 5) {
    return InvalidField("levels", absl::StrCat(*options.levels), "expected 0 to 5, or not set");
  }
  const int64_t triangles = int64_t{mesh.topology().triangle_count()}
                            << (2 * options.levels.value_or(0));
  if (triangles > options.max_triangles) {
    return LimitExceeded("triangles of the refined surface", triangles, options.max_triangles);
  }
  try {
    ASSIGN_OR_RETURN(ExportedStencils out, Build(mesh, distance, options));
    if (out.S.nonZeros() > options.max_entries) {
      return LimitExceeded("entries of the stencils", out.S.nonZeros(), options.max_entries);
    }
    return out;
  } catch (const std::bad_alloc&) {
    return WithDetail(
        absl::ResourceExhaustedError("the server has no memory left for these stencils"),
        {"LIMIT_EXCEEDED", "memory", "", "", absl::Seconds(1)});
  }
}

}  // namespace cagefit::server
