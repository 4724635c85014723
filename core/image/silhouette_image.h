// The image that the silhouette loss compares: a soft step across the outline of a shape.
//
//   A(p) = sigmoid(s |s| / sigma),   s = +-d(p) / half_side, positive inside
//
// with d(p) the distance from pixel centre p to the outline. The 0.5 contour is the outline itself,
// however finely that is divided.
#ifndef CAGEFIT_CORE_IMAGE_SILHOUETTE_IMAGE_H_
#define CAGEFIT_CORE_IMAGE_SILHOUETTE_IMAGE_H_

#include "core/image/image.h"
#include "core/image/outline_distance.h"

namespace cagefit {

inline constexpr double kSilhouetteSigma = 1e-4;  // squared units of NDC, as in [xie2022]

// Pixels beyond which A is within 1e-5 of 0 or 1: as far as an outline has to be measured. The
// image is exactly 0 or 1 beyond the reach of its OutlineDistance.
double SilhouetteReach(double sigma_ndc, double half_side);

// A(p), one channel. `inside`: of the same size, one channel, at least 0.5 at the pixels whose
// centre lies inside. `sigma_ndc` > 0 in squared NDC units; `half_side` > 0: Camera::half_side().
Image SilhouetteFromOutline(const OutlineDistance& distance, const Image& inside, double sigma_ndc,
                            double half_side);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_SILHOUETTE_IMAGE_H_
