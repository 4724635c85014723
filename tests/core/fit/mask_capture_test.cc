// A capture as a rig has it: points in every frame, masks of a few cameras in some, calibrated not
// quite right.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/random.h"
#include "core/cloud/surface_cloud.h"
#include "core/fit/extrapolation.h"
#include "core/fit/fitter.h"
#include "core/image/mesh_renderer.h"
#include "core/image/views.h"
#include "core/metrics/drift.h"
#include "core/subdiv/limit.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

constexpr int kFrames = 13;

// An open tube that bends, and whose rims are drawn out and in: a sleeve that moves.
Points3d Move(const Points3d& V, int frame) {
  const double time = 0.25 * frame;
  Points3d out = V;
  for (int64_t v = 0; v < V.cols(); ++v) {
    const double z = V(2, v) - 1, angle = 0.5 * std::sin(time) * z;
    const double stretched = z * (1 + 0.12 * std::sin(1.7 * time));
    const double radius = 1 + 0.1 * std::sin(2 * z + time);
    out.col(v) << radius * V(0, v) * std::cos(angle) + stretched * std::sin(angle),
        radius * V(1, v), stretched * std::cos(angle) - radius * V(0, v) * std::sin(angle);
  }
  return out;
}

Image HardMask(const TriangleMesh& mesh, const Camera& camera) {
  Image mask = RenderMesh(mesh, camera).silhouette;
  for (float& value : mask.values) value = value >= 0.5F ? 1 : 0;
  return mask;
}

// Mean drift over all frames, in units.
double MeanDrift(const FitOptions& options, int around, int along) {
  const TriangleMesh start = testing::Tube(20, 14);
  const TriangleMesh fine = testing::Tube(around, along);
  const ControlMesh cage = *ControlMesh::Create(Move(start.vertices, 0), start.triangles, {});
  const std::vector<Camera> cameras = SphereViews(8, {0, 0, 0}, 1.8, 256);
  std::vector<Camera> calibrated = cameras;
  Random random(4);
  for (Camera& camera : calibrated) {  // off by 2 pixels
    const double angle = random.Uniform(0, 2 * M_PI);
    camera.cx += 2 * std::cos(angle);
    camera.cy += 2 * std::sin(angle);
  }
  const LimitMesh limit = BuildLimitMesh(cage.topology(), cage.tags(), 2);
  std::optional<Fitter> fitter;
  std::optional<DriftMeter> meter;
  Points3d V = cage.vertices(), before(3, 0);
  double sum = 0;
  for (int frame = 0; frame < kFrames; ++frame) {
    const TriangleMesh truth{Move(fine.vertices, frame), fine.triangles};
    const PointCloud cloud = SurfaceCloud(truth, Points3f(3, 0));
    if (!fitter.has_value()) {
      fitter.emplace(
          *Fitter::Create(cage, *Normalization::FromBox(BoundingBox(cloud.points)), options));
    }
    std::vector<Image> masks(cameras.size());
    if (frame % 3 == 0) {
      for (size_t k = 0; k < cameras.size(); ++k) masks[k] = HardMask(truth, cameras[k]);
    }
    FrameSource images;
    images.cameras = &calibrated;
    images.masks = &masks;
    std::vector<Points3d> starts = {V};
    if (before.cols() > 0) starts.push_back(ExtrapolateMotion(before, V, 0.8));
    Points3d fitted;
    const auto summary =
        fitter->Fit(cloud, starts, nullptr, nullptr, &fitted,
                    frame == 0 ? StartKind::kTemplate : StartKind::kEarlierFit, images);
    EXPECT_TRUE(summary.ok()) << summary.status();
    if (!summary.ok()) return INFINITY;
    const bool shows = options.image.views != Views::kNone && frame % 3 == 0;
    EXPECT_EQ(summary->images, shows ? 8 : 0);
    if (frame > 0) before = V;
    V = fitted;
    Points3d surface;
    ApplyStencils(limit.position, V, &surface);
    if (!meter.has_value()) {
      meter.emplace(TriangleMesh{surface, limit.triangles}, truth.vertices);
    }
    sum += meter->Measure(surface, truth.vertices).mean / kFrames;
  }
  return sum;
}

TEST(MaskCaptureTest, MasksInSomeFramesHelpThoughCamerasAreOffByTwoPixels) {
  FitOptions options;
  options.boundary.weight = 0;  // which says where the rims are, too
  double alone = 0, with_masks = 0;
  // How much a tube turns about its axis is left to chance: two samplings of it.
  for (const auto& [around, along] : {std::pair(96, 68), std::pair(160, 112)}) {
    options.image.views = Views::kNone;
    const double by_points = MeanDrift(options, around, along);
    options.image.views = Views::kCameras;
    const double by_both = MeanDrift(options, around, along);
    RecordProperty("points_" + std::to_string(around), std::to_string(by_points));
    RecordProperty("both_" + std::to_string(around), std::to_string(by_both));
    alone += by_points;
    with_masks += by_both;
  }
  EXPECT_LT(with_masks, 0.95 * alone);
}

}  // namespace
}  // namespace cagefit
