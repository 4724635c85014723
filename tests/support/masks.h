// Cameras and masks as a client sends them.
#ifndef CAGEFIT_TESTS_SUPPORT_MASKS_H_
#define CAGEFIT_TESTS_SUPPORT_MASKS_H_

#include <string>

#include "core/codec/png.h"
#include "core/image/camera.h"

namespace cagefit::testing {

// 4 x 3 pixels, looking along z.
inline Camera SmallCamera(const std::string& name) {
  Camera camera;
  camera.name = name;
  camera.width = 4;
  camera.height = 3;
  camera.fx = camera.fy = 5;
  return camera;
}

inline std::string MaskPng(int width, int height, float value = 1) {
  return EncodePng(Image(width, height, 1, value), 8).value();
}

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_SUPPORT_MASKS_H_
