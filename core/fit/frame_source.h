// What a frame holds beside its points. User units.
#ifndef CAGEFIT_CORE_FIT_FRAME_SOURCE_H_
#define CAGEFIT_CORE_FIT_FRAME_SOURCE_H_

#include <cstdint>
#include <vector>

#include "core/energy/landmark_term.h"
#include "core/image/camera.h"
#include "core/image/image.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

// Null: none of that.
struct FrameSource {
  const TriangleMesh* mesh = nullptr;            // its surface; null: known by its points alone
  const std::vector<Camera>* cameras = nullptr;  // real ones
  const std::vector<Image>* masks = nullptr;     // by camera, 1 inside; empty where one is missing
  const std::vector<Landmark>* landmarks = nullptr;  // CheckLandmarks holds
  uint64_t frame = 0;                                // goes into the seed of the views
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_FRAME_SOURCE_H_
