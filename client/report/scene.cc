#include "client/report/scene.h"

#include <algorithm>
#include <utility>

#include "client/io/geometry_file.h"
#include "client/report/deviation.h"
#include "client/report/shown_frames.h"
#include "core/metrics/surface_metrics.h"
#include "core/metrics/surface_samples.h"
#include "core/subdiv/limit.h"

namespace cagefit::client {
namespace {

constexpr int64_t kBytesPerPoint = 7;  // three coordinates of two bytes and the deviation

// Evenly spread over their order, without those that lie far off: the view could not hold them.
Points3d SomePoints(const Points3d& target, const Box& surface, int64_t most) {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(surface.diagonal() / 2);
  const int64_t count = std::min<int64_t>(most, target.cols());
  Points3d points(3, count);
  int64_t kept = 0;
  for (int64_t k = 0; k < count; ++k) {
    const auto point = target.col(k * target.cols() / count);
    const bool is_near = (point.array() >= (surface.min - margin).array()).all() &&
                         (point.array() <= (surface.max + margin).array()).all();
    if (is_near) points.col(kept++) = point;
  }
  points.conservativeResize(3, kept);
  return points;
}

class FrameMeasure {
 public:
  FrameMeasure(const ControlMesh& cage, const DisplayMesh& display, int64_t most_points)
      : fine_(BuildLimitMesh(cage.topology(), cage.tags(), kMetricLevels)),
        display_(display),
        most_points_(most_points) {}

  SceneFrame Measure(const ReportFrame& fitted) {
    SceneFrame frame;
    frame.number = fitted.number;
    frame.control_vertices = fitted.control_vertices;
    const auto target = ReadGeometry(fitted.file);
    if (!target.ok()) return frame;
    TriangleMesh drawn{{}, display_.limit_triangles};
    ApplyStencils(display_.position, *fitted.control_vertices, &drawn.vertices);
    frame.surface_deviations = SurfaceDeviations(drawn, *target);
    // Points as MeasureFrames takes them, and its surface.
    const Points3d points =
        target->is_cloud() ? target->mesh.vertices : SampleSurface(target->mesh, 1, /*seed=*/1);
    frame.target_points = points.cols();
    frame.points = SomePoints(points, BoundingBox(drawn.vertices), most_points_);
    TriangleMesh fine{{}, fine_.triangles};
    ApplyStencils(fine_.position, *fitted.control_vertices, &fine.vertices);
    bvh_.Build(fine.vertices, fine.triangles);
    frame.point_deviations = PointDeviations(frame.points, fine, bvh_);
    return frame;
  }

 private:
  const LimitMesh fine_;
  const DisplayMesh& display_;
  const int64_t most_points_;
  TriangleBvh bvh_;
};

}  // namespace

Scene BuildScene(const ControlMesh& cage, const std::vector<ReportFrame>& frames,
                 const SceneLimits& limits) {
  Scene scene;
  scene.mesh = BuildDisplayMesh(cage, limits.surface_vertices);
  if (frames.empty()) return scene;
  const auto count = static_cast<int64_t>(frames.size());
  const int64_t points = std::clamp(limits.bytes / 4 / count / kBytesPerPoint, limits.fewest_points,
                                    limits.most_points);
  const int64_t frame_bytes =
      6 * cage.vertex_count() + scene.mesh.position.rows() + kBytesPerPoint * points;
  std::vector<double> rms;
  for (const ReportFrame& frame : frames) rms.push_back(frame.rms);
  const auto most = static_cast<size_t>(std::max<int64_t>(2, limits.bytes / frame_bytes));
  FrameMeasure measure(cage, scene.mesh, points);
  for (const size_t k : ShownFrames(rms, most)) scene.frames.push_back(measure.Measure(frames[k]));
  return scene;
}

}  // namespace cagefit::client
