// Depths and normals as pictures to look at: values from 0 to 1, as PNG holds them.
#ifndef CAGEFIT_CLIENT_IO_PICTURE_H_
#define CAGEFIT_CLIENT_IO_PICTURE_H_

#include "core/image/image.h"

namespace cagefit::client {

// 1 at the nearest depth, 0.1 at the farthest, linear between them; 0 where there is none.
Image DepthPicture(const Image& depth);

// (1 + n) / 2 per component; 0 where there is none.
Image NormalPicture(const Image& normals);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_IO_PICTURE_H_
