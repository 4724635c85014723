#include "client/io/picture.h"

#include <algorithm>

namespace cagefit::client {

Image DepthPicture(const Image& depth) {
  constexpr float kFarthest = 0.1F;
  float nearest = 0, farthest = 0;
  for (const float z : depth.values) {
    if (z <= 0) continue;
    nearest = nearest == 0 ? z : std::min(nearest, z);
    farthest = std::max(farthest, z);
  }
  const float range = farthest > nearest ? farthest - nearest : 1;
  Image out(depth.width, depth.height);
  for (size_t p = 0; p < depth.values.size(); ++p) {
    const float z = depth.values[p];
    if (z > 0) out.values[p] = 1 - (1 - kFarthest) * (z - nearest) / range;
  }
  return out;
}

Image NormalPicture(const Image& normals) {
  Image out(normals.width, normals.height, 3);
  for (size_t p = 0; p < normals.values.size(); p += 3) {
    const float* n = &normals.values[p];
    if (n[0] == 0 && n[1] == 0 && n[2] == 0) continue;
    for (int c = 0; c < 3; ++c) out.values[p + c] = 0.5F * (1 + n[c]);
  }
  return out;
}

}  // namespace cagefit::client
