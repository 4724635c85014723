// Where on a Loop subdivision surface.
#ifndef CAGEFIT_CORE_SUBDIV_SURFACE_POINT_H_
#define CAGEFIT_CORE_SUBDIV_SURFACE_POINT_H_

#include <Eigen/Core>
#include <cstdint>

namespace cagefit {

// The point of control triangle `face` with weights 1 - u - v, u, v of its corners 0, 1, 2.
// u, v >= 0, u + v <= 1.
struct SurfacePoint {
  int32_t face = -1;
  double u = 0, v = 0;
};

// How many derivatives of a point are wanted.
enum class Derivatives { kNone = 0, kFirst = 1, kSecond = 2 };

// The limit surface's position and derivatives at a point; 0 where they were not asked for.
struct SurfaceJet {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d du = Eigen::Vector3d::Zero(), dv = Eigen::Vector3d::Zero();
  Eigen::Vector3d duu = Eigen::Vector3d::Zero(), duv = Eigen::Vector3d::Zero(),
                  dvv = Eigen::Vector3d::Zero();
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_SURFACE_POINT_H_
