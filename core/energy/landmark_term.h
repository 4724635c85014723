// Landmarks: places on the surface, or control vertices, whose position is known.
//
//   E_land = delta (n/L) sum_l | X_l - p_l |^2
//
// n control vertices, L landmarks, X_l the control vertex or the point of the limit surface, p_l
// where it is known to be.
#ifndef CAGEFIT_CORE_ENERGY_LANDMARK_TERM_H_
#define CAGEFIT_CORE_ENERGY_LANDMARK_TERM_H_

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "absl/status/status.h"
#include "absl/types/span.h"
#include "core/energy/attachments.h"
#include "core/mesh/control_mesh.h"
#include "core/subdiv/limit_surface.h"
#include "core/subdiv/surface_point.h"

namespace cagefit {

struct Landmark {
  int32_t vertex = -1;  // control vertex; -1: the surface at `at`
  SurfacePoint at;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

// INVALID_ARGUMENT that names the landmark by its index, and the value: for a vertex or a triangle
// that the mesh does not have, a point outside its triangle, a position that is not finite.
absl::Status CheckLandmarks(const std::vector<Landmark>& landmarks, int64_t vertices,
                            int64_t triangles);

// Not thread-safe. The rows of a place are kept as long as the same places are asked for.
class LandmarkTerm {
 public:
  LandmarkTerm(const Topology& topology, const CreaseTags& tags)
      : topology_(topology), tags_(tags) {}

  // `landmarks` must pass CheckLandmarks. `weight` is delta; with 0, or no landmarks, there are no
  // attachments.
  void SetTarget(absl::Span<const Landmark> landmarks, double weight);
  const Attachments& attachments() const { return attachments_; }

 private:
  StencilMatrix Rows(absl::Span<const Landmark> landmarks);

  Topology topology_;
  CreaseTags tags_;
  std::unique_ptr<LimitSurface> surface_;  // empty until a landmark is on it
  std::vector<Landmark> places_;           // whose rows attachments_ has
  Attachments attachments_;
};

}  // namespace cagefit

#endif  // CAGEFIT_CORE_ENERGY_LANDMARK_TERM_H_
