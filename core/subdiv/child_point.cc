#include "core/subdiv/child_point.h"

namespace cagefit {

// Corner c of the triangle is the first of child c, whose coordinates are twice the weights of the
// corners c + 1, c + 2. Child 3 is (e0 e1 e2), e0 between corners 0 and 1: its weights are 1 - 2 v,
// 1 - 2 w, 1 - 2 u.
ChildPoint InChild(double u, double v) {
  const double w = 1 - u - v;
  if (w >= 0.5) return {0, 2 * u, 2 * v};
  if (u >= 0.5) return {1, 2 * v, 2 * w};
  if (v >= 0.5) return {2, 2 * w, 2 * u};
  return {3, 1 - 2 * w, 1 - 2 * u};
}

Eigen::Vector2d FromChild(const ChildPoint& point) {
  const double u = point.u / 2, v = point.v / 2;
  switch (point.child) {
    case 0:
      return {u, v};
    case 1:
      return {1 - u - v, u};
    case 2:
      return {v, 1 - u - v};
    default:
      return {0.5 - v, u + v};
  }
}

Eigen::Matrix2d ChildJacobian(int child) {
  Eigen::Matrix2d J;
  switch (child) {
    case 0:
      J << 2, 0, 0, 2;
      break;
    case 1:
      J << 0, 2, -2, -2;
      break;
    case 2:
      J << -2, -2, 2, 0;
      break;
    default:
      J << 2, 2, -2, 0;
  }
  return J;
}

}  // namespace cagefit
