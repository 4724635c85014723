// The limit surface of a control mesh as a Draco mesh.
#ifndef CAGEFIT_SERVER_SESSION_SURFACE_EXPORT_H_
#define CAGEFIT_SERVER_SESSION_SURFACE_EXPORT_H_

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::server {

struct SurfaceExportOptions {
  uint32_t levels = 2;         // refinement levels, 0 to 5
  uint32_t position_bits = 0;  // Draco quantisation, 8 to 30; 0: lossless float32
  int64_t max_triangles = 5'000'000;
};

// INVALID_ARGUMENT naming field and value; RESOURCE_EXHAUSTED above max_triangles.
absl::StatusOr<std::string> ExportSurface(const ControlMesh& mesh,
                                          const SurfaceExportOptions& options);

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_SURFACE_EXPORT_H_
