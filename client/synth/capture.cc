#include "client/synth/capture.h"

#include "core/base/check_range.h"
#include "core/base/random.h"
#include "core/base/status.h"
#include "core/mesh/area_sampler.h"

namespace cagefit::client {
namespace {

// A step is then about 1 % of the diagonal.
constexpr double kPeriodFrames = 60;
constexpr double kOutlierBox = 1.2;  // their box, of the shape's

}  // namespace

absl::Status CaptureOptions::Validate() const {
  RETURN_IF_ERROR(CheckRange("frames", frames, 1, 100'000));
  RETURN_IF_ERROR(CheckRange("points", static_cast<double>(points), kMinTargetPoints, 50e6));
  RETURN_IF_ERROR(CheckRange("noise", noise, 0, 0.1));
  return CheckRange("outliers", outliers, 0, 0.9);
}

double FrameTime(int frame) { return frame / kPeriodFrames; }

PointCloud CaptureFrame(const SynthShape& shape, int frame, const CaptureOptions& options) {
  const double time = FrameTime(frame);
  const Points3d moved = shape.Vertices(time);
  const Triangles& triangles = shape.rest().triangles;
  const Box box = BoundingBox(moved);
  const AreaSampler by_area(moved, triangles);
  Random random(options.seed * 1'000'003 + static_cast<uint64_t>(frame));
  PointCloud cloud;
  cloud.points.resize(3, options.points);
  cloud.normals.resize(3, options.points);
  for (int64_t i = 0; i < options.points; ++i) {
    if (random.Uniform() < options.outliers) {
      const Eigen::Vector3d share = random.UniformVector();
      const Eigen::Vector3d middle = 0.5 * (box.min + box.max);
      cloud.points.col(i) =
          (middle + kOutlierBox * (share.array() - 0.5).matrix().cwiseProduct(box.size()))
              .cast<float>();
      cloud.normals.col(i) = random.NormalVector().normalized().cast<float>();
      continue;
    }
    const AreaSampler::Point drawn = by_area.Draw(&random);
    Eigen::Vector3d near = Eigen::Vector3d::Zero();
    for (int c = 0; c < 3; ++c) {
      near += drawn.weights[c] * shape.rest().vertices.col(triangles(c, drawn.triangle));
    }
    const SurfacePoint moved_point = shape.MovePoint(shape.OnRest(near), time);
    Eigen::Vector3d point = moved_point.position;
    if (options.noise > 0) point += options.noise * box.diagonal() * random.NormalVector();
    cloud.points.col(i) = point.cast<float>();
    cloud.normals.col(i) = moved_point.normal.cast<float>();
  }
  return cloud;
}

}  // namespace cagefit::client
