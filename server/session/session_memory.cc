#include "server/session/session_memory.h"

#include <algorithm>

#include "core/fit/tolerance_fit.h"

namespace cagefit::server {
namespace {

// Of the images that are compared.
int64_t ImageBytes(const SessionConfig& config) {
  const ImageOptions& image = config.fit.image;
  int64_t views = 0;
  if (image.views == Views::kCameras) views = static_cast<int64_t>(config.cameras.size());
  if (image.views == Views::kSphere || image.views == Views::kTutorial) views = image.view_count;
  const int64_t pixel =
      image.mode == SilhouetteMode::kPytorch3d ? 150 + 16 * image.faces_per_pixel : 150;
  return pixel * views * image.size * image.size;
}

}  // namespace

int64_t IdleSessionBytes(const SessionConfig& config, int32_t vertices) {
  return (32 << 10) + int64_t{600} * vertices + 1000 * static_cast<int64_t>(config.cameras.size());
}

int64_t ModelBytes(const SessionConfig& config, int32_t vertices, int64_t points) {
  const int64_t per_vertex = config.fit.solver.solver == Solver::kCeres ? 46'000 : 16'000;
  return per_vertex * vertices + 200 * points + std::min<int64_t>(800 * points, 9 << 20) +
         ImageBytes(config);
}

int32_t MostFirstVertices(const SessionConfig& config, const SessionLimits& limits,
                          int64_t points) {
  const int32_t start = config.control_mesh.has_value() ? config.control_mesh->vertex_count()
                                                        : config.make_template.vertices;
  if (!config.tolerance.has_value()) return start;
  const int32_t most = config.tolerance->max_vertices > 0 ? config.tolerance->max_vertices
                                                          : MostToleranceVertices(points);
  return std::max(start, std::min(most, limits.max_control_vertices));
}

int64_t HeldBytes(const Frame& frame) {
  int64_t bytes = static_cast<int64_t>(frame.bytes.size());
  bytes += static_cast<int64_t>(frame.landmarks.size() * sizeof(Landmark));
  if (frame.cloud.ok()) {
    bytes += static_cast<int64_t>((frame.cloud->points.size() + frame.cloud->normals.size()) *
                                  sizeof(float));
  }
  if (frame.mesh.has_value()) {
    bytes += static_cast<int64_t>(frame.mesh->vertices.size() * sizeof(double) +
                                  frame.mesh->triangles.size() * sizeof(int32_t));
  }
  for (const Image& mask : frame.masks) {
    bytes += static_cast<int64_t>(mask.values.size() * sizeof(float));
  }
  return bytes;
}

}  // namespace cagefit::server
