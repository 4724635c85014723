// The quartic box spline that Loop's scheme converges to where all valences are 6 [stam1998].
//
//            7 ---- 6                 A regular triangle (0 1 2) and its one-ring,
//            counter-clockwise:
//          /  \   /  \                3, 4, 5 lie across edges 01, 12, 20. The rings of the corners
//         3 --- 0 --- 5               are 0: 1 2 5 6 7 3,  1: 2 0 3 8 9 4,  2: 0 1 4 10 11 5.
//       /  \  /  \  /  \              .
//      8 --- 1 --- 2 --- 11
//       \  /  \  /  \  /
//         9 --- 4 --- 10
#ifndef CAGEFIT_CORE_SUBDIV_BOX_SPLINE_H_
#define CAGEFIT_CORE_SUBDIV_BOX_SPLINE_H_

#include <array>

#include "core/subdiv/surface_point.h"

namespace cagefit {

// Weight of one control point in position, du, dv, duu, duv, dvv.
inline constexpr int kJetSize = 6;
using JetWeights = std::array<double, kJetSize>;

// Number of the weights that `derivatives` asks for: 1, 3 or 6.
inline constexpr int JetCount(Derivatives derivatives) {
  return derivatives == Derivatives::kNone ? 1 : derivatives == Derivatives::kFirst ? 3 : 6;
}

// Weights of the 12 points at weights (1 - u - v, u, v) of the corners. Positions sum to 1,
// derivatives to 0. Weights that were not asked for are 0.
using BoxSplineWeights = std::array<JetWeights, 12>;
void EvaluateBoxSpline(double u, double v, Derivatives derivatives, BoxSplineWeights* weights);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_BOX_SPLINE_H_
