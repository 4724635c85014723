// Cameras around a moving shape, and the masks that they take of it.
#ifndef CAGEFIT_CLIENT_SYNTH_RIG_H_
#define CAGEFIT_CLIENT_SYNTH_RIG_H_

#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "client/synth/shape.h"
#include "core/image/camera.h"
#include "core/image/image.h"

namespace cagefit::client {

struct RigOptions {
  int cameras = 0;   // 0 to 64
  int size = 512;    // pixels of each side of an image; 64 to 2,048
  int every = 1;     // masks of every so many frames, from the first on; 1 to 100,000
  double error = 0;  // of the calibration: pixels that each principal point is off; 0 to 100

  absl::Status Validate() const;
};

// Immutable.
class Rig {
 public:
  // Cameras evenly around all that `shape` does, camera_00 and so on. Directions of the errors are
  // drawn by `seed`.
  Rig(const SynthShape& shape, const RigOptions& options, uint64_t seed);

  // As they were calibrated, with the error.
  const std::vector<Camera>& calibrated() const { return calibrated_; }
  // Where they are in truth.
  const std::vector<Camera>& cameras() const { return cameras_; }

  bool TakesMasksOf(int frame) const { return frame % every_ == 0; }
  // What camera k sees at `time`: 1 inside, 0 outside, as a segmentation gives it.
  Image Mask(const SynthShape& shape, double time, size_t k) const;

 private:
  std::vector<Camera> cameras_, calibrated_;
  int every_;
};

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_SYNTH_RIG_H_
