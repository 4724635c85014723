// A moving shape as a rig would see it: new random points in every frame.
#ifndef CAGEFIT_CLIENT_SYNTH_CAPTURE_H_
#define CAGEFIT_CLIENT_SYNTH_CAPTURE_H_

#include <cstdint>

#include "absl/status/status.h"
#include "client/synth/shape.h"
#include "core/cloud/point_cloud.h"

namespace cagefit::client {

struct CaptureOptions {
  int frames = 30;           // 1 to 100,000
  int64_t points = 100'000;  // of a frame; 16 to 50,000,000
  uint64_t seed = 1;
  double noise = 0;     // standard deviation, share of the bounding-box diagonal; 0 to 0.1
  double outliers = 0;  // share of the points that lie anywhere in the box; 0 to 0.9

  absl::Status Validate() const;
};

// One period takes 60 frames, whatever their number: time of frame k.
double FrameTime(int frame);

// Points of frame `frame` with unit normals, uniform by area. The same for one seed on every
// machine; frames may be made in any order. Outliers have random normals.
PointCloud CaptureFrame(const SynthShape& shape, int frame, const CaptureOptions& options);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_SYNTH_CAPTURE_H_
