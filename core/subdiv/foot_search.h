// Descent on the limit surface to a point that is nearest to x among its neighbours.
//
// Minimises f = |S(u, v) - x|^2 / 2, triangle by triangle: the step is the minimum over the closed
// triangle of Newton's model, made convex where it is not; a step that an edge holds back goes on
// across it. f never grows. The search ends where no triangle that holds the
// point offers a step: in a triangle, on a boundary or crease, or at a vertex. Extraordinary
// vertices have no model: a step may end there, and leaves again if f falls in any direction.
#ifndef CAGEFIT_CORE_SUBDIV_FOOT_SEARCH_H_
#define CAGEFIT_CORE_SUBDIV_FOOT_SEARCH_H_

#include "core/subdiv/limit_surface.h"
#include "core/subdiv/surface_foot.h"
#include "core/subdiv/triangle_step.h"

namespace cagefit {

class FootSearch {
 public:
  // Steps shorter than `tolerance` times the longest edge of the control triangle end the search.
  // The arguments must outlive the object.
  FootSearch(const LimitSurface& surface, const Points3d& control_points, const Eigen::Vector3d& x,
             double tolerance);

  SurfaceFoot Run(const SurfacePoint& start) const;

 private:
  struct State {
    SurfacePoint at;
    SurfaceJet jet;
    double f = 0;
    bool at_pole = false;  // an extraordinary vertex
  };
  struct Step : TriangleStep {
    double length = 0;       // over the longest edge
    bool is_newton = false;  // by the exact second derivatives
  };

  State Evaluate(const SurfacePoint& at, Derivatives derivatives) const;
  double Value(const SurfacePoint& at) const;
  Step FindStep(const State& state) const;
  bool Take(const Step& step, State* state) const;
  bool LeaveTriangle(State* state) const;
  bool LeavePole(State* state) const;
  SurfaceFoot Foot(const State& state) const;
  double LongestEdge(int32_t face) const;

  const LimitSurface& surface_;
  const Points3d& control_points_;
  const Eigen::Vector3d& x_;
  const double tolerance_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_FOOT_SEARCH_H_
