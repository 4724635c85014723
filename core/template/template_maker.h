// Makes a control mesh from a triangle mesh or from a cloud. The only part of core that links
// Open3D.
#ifndef CAGEFIT_CORE_TEMPLATE_TEMPLATE_MAKER_H_
#define CAGEFIT_CORE_TEMPLATE_TEMPLATE_MAKER_H_

#include <optional>

#include "absl/status/statusor.h"
#include "core/cloud/point_cloud.h"
#include "core/mesh/control_mesh.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

struct TemplateOptions {
  int32_t vertices = 2000;  // control vertices wanted; the result is within 1 %. 4 to 1,000,000
  // Degrees from which an edge of a mesh starts a crease (DetectCreases), 0 to 180; 0: none. Not
  // set: kDefaultCreaseAngle, and only on meshes whose creases look like a part's.
  std::optional<double> crease_angle;
  // Creases and corners that the mesh is known to have, by its own vertices. Where there are any,
  // they are all it has, whatever crease_angle says. Those of repaired triangles are left out.
  CreaseTags tags = {};

  absl::Status Validate() const;
};

// What was done on the way, for the log.
struct TemplateReport {
  int64_t input_vertices = 0;
  int32_t components_kept = 0, components_dropped = 0;
  int32_t boundary_loops = 0;
  int32_t crease_edges = 0, corners = 0;  // of the control mesh
  int64_t repaired_triangles = 0;         // left out: degenerate, doubled or a third one at an edge
  int64_t repaired_vertices = 0;          // split: several fans of triangles met there
};

// Quadric edge collapse [garland1997] to the requested count, open boundaries and creases kept, the
// latter as tags. Creases that need more vertices than were asked for are given up. The result is
// edge- and vertex-manifold with interior valence 3 or more. INVALID_ARGUMENT for a bad option or
// unusable input, FAILED_PRECONDITION naming the step when no valid control mesh of that size came
// out.
absl::StatusOr<ControlMesh> TemplateFromMesh(const TriangleMesh& mesh,
                                             const TemplateOptions& options,
                                             TemplateReport* report);

// Screened Poisson reconstruction [kazhdan2013], trimmed where there were no points (an open
// surface stays open), then TemplateFromMesh. The cloud needs normals (EstimateNormals).
absl::StatusOr<ControlMesh> TemplateFromCloud(const PointCloud& cloud,
                                              const TemplateOptions& options,
                                              TemplateReport* report);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_TEMPLATE_TEMPLATE_MAKER_H_
