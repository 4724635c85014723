// Points of the limit surface as rows over the control vertices, for clients.
#ifndef CAGEFIT_SERVER_SESSION_STENCIL_EXPORT_H_
#define CAGEFIT_SERVER_SESSION_STENCIL_EXPORT_H_

#include <cstdint>
#include <optional>

#include "absl/status/statusor.h"
#include "core/fit/fit_options.h"
#include "core/mesh/control_mesh.h"
#include "core/subdiv/stencils.h"

namespace cagefit::server {

struct StencilExportOptions {
  std::optional<uint32_t> levels;     // refinement steps, 0 to 5; not set: the samples of the fit
  int64_t max_triangles = 5'000'000;  // of the refined mesh
  int64_t max_entries = int64_t{1} << 26;
};

struct ExportedStencils {
  StencilMatrix S;      // compressed, columns of a row ascending
  Triangles triangles;  // of the rows; none where they are the samples of the fit
};

// `distance` says what the fit samples. INVALID_ARGUMENT naming field and value; RESOURCE_EXHAUSTED
// above a limit.
absl::StatusOr<ExportedStencils> ExportStencils(const ControlMesh& mesh,
                                                const DistanceOptions& distance,
                                                const StencilExportOptions& options);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_STENCIL_EXPORT_H_
