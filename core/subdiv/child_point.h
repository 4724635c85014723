// Points of a triangle in the coordinates of its four children (refine.h numbers these).
#ifndef CAGEFIT_CORE_SUBDIV_CHILD_POINT_H_
#define CAGEFIT_CORE_SUBDIV_CHILD_POINT_H_

#include <Eigen/Core>

namespace cagefit {

// u, v weigh corners 1 and 2 of child `child`.
struct ChildPoint {
  int child = 0;
  double u = 0, v = 0;
};

// The child that the point of weights (1 - u - v, u, v) lies in, with its coordinates there.
ChildPoint InChild(double u, double v);

// The way back: (u, v) in the triangle.
Eigen::Vector2d FromChild(const ChildPoint& point);

// Derivatives of the child's coordinates by the triangle's: (du'/du, du'/dv; dv'/du, dv'/dv).
Eigen::Matrix2d ChildJacobian(int child);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_CHILD_POINT_H_
