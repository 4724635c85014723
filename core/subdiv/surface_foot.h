// The foot of a point on the limit surface.
#ifndef CAGEFIT_CORE_SUBDIV_SURFACE_FOOT_H_
#define CAGEFIT_CORE_SUBDIV_SURFACE_FOOT_H_

#include <Eigen/Core>

#include "core/subdiv/surface_point.h"

namespace cagefit {

struct SurfaceFoot {
  SurfacePoint at;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // unit; on a crease that of the side of `at`
  double distance = 0;
  bool on_boundary = false;  // on an edge of the mesh that has one triangle
  // The point is off along the normal, but for the tolerance of the search: no boundary, crease or
  // vertex holds the foot back.
  bool is_free = false;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_SURFACE_FOOT_H_
