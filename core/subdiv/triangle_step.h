// Minimum of a convex quadratic over the triangle u, v >= 0, u + v <= 1: a Newton step that stays
// on a patch.
#ifndef CAGEFIT_CORE_SUBDIV_TRIANGLE_STEP_H_
#define CAGEFIT_CORE_SUBDIV_TRIANGLE_STEP_H_

#include <Eigen/Core>

namespace cagefit {

// Argument p + d, in the triangle, of the minimum of g.d + d.H d / 2; H symmetric, positive
// definite. Edge c runs from corner c to c + 1, corner 0 has u = v = 0, corner 1 u = 1.
struct TriangleStep {
  Eigen::Vector2d target;
  int edge = -1;  // that holds the step back, or -1
};
TriangleStep MinimizeInTriangle(const Eigen::Vector2d& p, const Eigen::Vector2d& g,
                                const Eigen::Matrix2d& H);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_TRIANGLE_STEP_H_
