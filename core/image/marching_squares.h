// The outline {F = level} of a field given at pixel centres, by marching squares.
//
// Points lie on the edges between neighbouring pixel centres, where F is linear. In a cell whose
// diagonals differ in sign, the bilinear saddle decides which pair is joined [nielson1991]: that
// with the larger product |F - level|, inside if equal. Beyond the outermost centres F goes on with
// their values for one pixel: contours run straight across the image's border and never along it.
#ifndef CAGEFIT_CORE_IMAGE_MARCHING_SQUARES_H_
#define CAGEFIT_CORE_IMAGE_MARCHING_SQUARES_H_

#include "core/image/image.h"
#include "core/image/outline.h"

namespace cagefit {

// Outline of {F >= level} in the field's pixels. Every segment has the inside to its right as seen
// in the image (x right, y down). Points are shared. `field` has one channel, finite values.
void ExtractOutline(const Image& field, float level, Outline* out);

// Whether a point of [-1, width] x [-1, height] is on the inner side of that outline.
bool InsideOutline(const Image& field, float level, const Eigen::Vector2d& point);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_MARCHING_SQUARES_H_
