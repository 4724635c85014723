// What a view shows of the shape to be fitted, whatever it was made from.
#ifndef CAGEFIT_CORE_IMAGE_IMAGE_TARGET_H_
#define CAGEFIT_CORE_IMAGE_IMAGE_TARGET_H_

#include "core/image/camera.h"
#include "core/image/image.h"

namespace cagefit {

// All images are camera.width x camera.height.
struct ImageTarget {
  Camera camera;     // without distortion
  Image silhouette;  // A(p) of core/image/silhouette_image.h
  Image observed;    // 1 where the silhouette is known, else 0; empty: known everywhere
  Image depth;       // camera z of the visible surface, 0 where unknown; empty: unknown everywhere
  Image normals;     // its unit normal, 3 channels, world axes; 0 and empty likewise
  double slack = 0;  // pixels by which the camera's principal point may be off
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_IMAGE_TARGET_H_
