// What a report page shows in 3D: the fitted surface of some frames, their targets, and how far
// these are from each other.
#ifndef CAGEFIT_CLIENT_REPORT_SCENE_H_
#define CAGEFIT_CLIENT_REPORT_SCENE_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "client/report/display_mesh.h"
#include "core/mesh/control_mesh.h"

namespace cagefit::client {

struct ReportFrame {
  size_t number = 0;
  std::string file;                            // of its target
  const Points3d* control_vertices = nullptr;  // 3 x n
  double rms = 0;                              // of its distances, in any unit: to find the worst
};

struct SceneFrame {
  size_t number = 0;
  const Points3d* control_vertices = nullptr;
  // Empty, as all below, where the target could not be read again. In units, as of deviation.h.
  std::vector<double> surface_deviations;  // of each limit vertex
  Points3d points;                         // of the target, some
  std::vector<double> point_deviations;
  int64_t target_points = 0;  // that the target has
};

struct Scene {
  DisplayMesh mesh;
  std::vector<SceneFrame> frames;
};

// What a scene may take of a page.
struct SceneLimits {
  int64_t surface_vertices = 20'000;  // that refinement may come to
  int64_t bytes = int64_t{4} << 20;   // of all frames together, as payload.h stores them
  int64_t most_points = 20'000;       // of a frame's target; fewer the more frames there are
  int64_t fewest_points = 1'000;
};

// Of `cage` at these vertices: every frame, or as many as the limits allow (shown_frames.h). Reads
// their targets, one after the other, and measures on all threads.
Scene BuildScene(const ControlMesh& cage, const std::vector<ReportFrame>& frames,
                 const SceneLimits& limits = {});

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_REPORT_SCENE_H_
