// How far the points of a cloud lie off the surface that they were taken from.
//
// A quadric z(u, v) is fitted to the points of a ball about each of some hundred points. What it
// leaves is noise and curvature, told apart twice:
//   by scale   the residual e of balls that are too small for the noise grows with their radius,
//   and
//              so does that of curvature; only noise leaves it as it is. Balls grow until
//              r >= 4 e; the ratio of e there and in the next larger ball is 1 for noise,
//              sqrt(3) and more for curvature;
//   by place   the difference of two neighbours' residuals has noise in it (variance 2 sigma^2)
//              but hardly any of the quadric's misfit, which is smooth.
// With medians over each ball and over all balls: neither outliers, creases, holes nor a wrong
// normal (normals are not read) count for much.
#ifndef CAGEFIT_CORE_CLOUD_NOISE_H_
#define CAGEFIT_CORE_CLOUD_NOISE_H_

#include "core/cloud/cell_grid.h"

namespace cagefit {

struct NoiseEstimate {
  double sigma = 0;   // standard deviation across the surface, in the cloud's units
  double radius = 0;  // of balls in which a plane or quadric sees the surface through the noise
};

// Of about 250 points, evenly spread over the grid's order, whatever the number of points: some
// milliseconds. Zero where there are too few points (below 500) or most of them coincide. Uses
// several threads; the result does not depend on their number.
NoiseEstimate EstimateNoise(const CellGrid& grid);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_CLOUD_NOISE_H_
