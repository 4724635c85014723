// Masks of Loop's subdivision scheme [loop1987] with Loop's own vertex weight.
//
//   vertex, interior of valence k:  (1 - k beta) v + beta sum of the ring,
//     beta(k) = (5/8 - (3/8 + cos(2 pi / k) / 4)^2) / k
//   edge, interior:  3/8 3/8 for its ends, 1/8 1/8 for the opposite corners
//   vertex on a boundary or crease:  3/4, 1/8 1/8 along the curve;  edge there:  1/2 1/2
//   limit, interior:  (1 - k l) v + l sum of the ring,  l = 1 / (k + 3 / (8 beta))
//   limit on a boundary or crease:  2/3, 1/6 1/6;   corner:  the vertex itself
//
// A dart (interior, one crease ends there) is refined as a smooth vertex, but the edge mask 1/2 1/2
// on its crease changes its limit.
#ifndef CAGEFIT_CORE_SUBDIV_LOOP_MASKS_H_
#define CAGEFIT_CORE_SUBDIV_LOOP_MASKS_H_

#include <vector>

namespace cagefit {

// Weight of each of the k ring vertices in the vertex mask. k >= 3.
double LoopBeta(int k);

// Weight of each of the k ring vertices in the limit position mask. k >= 3.
double LoopLimitWeight(int k);

// Limit position mask of a dart: weights of its k ring vertices, counter-clockwise from the one on
// the crease. The dart itself has what they lack to 1. k >= 3.
std::vector<double> LoopDartLimitWeights(int k);

inline constexpr double kEdgeEndWeight = 3.0 / 8.0;
inline constexpr double kEdgeOppositeWeight = 1.0 / 8.0;
inline constexpr double kCurveVertexWeight = 3.0 / 4.0;
inline constexpr double kCurveNeighborWeight = 1.0 / 8.0;
inline constexpr double kCurveLimitVertexWeight = 2.0 / 3.0;
inline constexpr double kCurveLimitNeighborWeight = 1.0 / 6.0;

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_LOOP_MASKS_H_
