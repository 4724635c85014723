// A triangle mesh as a camera sees it.
#ifndef CAGEFIT_CORE_IMAGE_PROJECTED_MESH_H_
#define CAGEFIT_CORE_IMAGE_PROJECTED_MESH_H_

#include "core/base/types.h"
#include "core/image/camera.h"

namespace cagefit {

// Nearer than this share of the farthest vertex's depth, nothing is seen.
inline constexpr double kNearShare = 1e-3;

struct ProjectedMesh {
  Points3d points;  // x, y in pixels, depth; x, y of a vertex that is too near mean nothing
  double near_depth = 0;

  bool IsSeen(int32_t vertex) const { return points(2, vertex) > near_depth; }
  // Whether all corners are in front of the near plane: a triangle that reaches behind it is left
  // out as a whole.
  bool IsSeen(const Triangles& triangles, int64_t f) const {
    return IsSeen(triangles(0, f)) && IsSeen(triangles(1, f)) && IsSeen(triangles(2, f));
  }
};

// `vertices` (3 x n) in the camera's world units. Distortion is left out. Keeps the capacity of
// `out`.
void ProjectMesh(const Points3d& vertices, const Camera& camera, ProjectedMesh* out);

// Adds to `gradient` (3 x n) what a gradient with respect to the pixels x, y (`by_pixel`, 2 x n)
// is with respect to the vertices (3 x n).
void AddVertexGradient(const Points3d& vertices, const Camera& camera,
                       const Eigen::Matrix<double, 2, Eigen::Dynamic>& by_pixel,
                       Points3d* gradient);

// d(u, v)/dX of Camera::Project.
Eigen::Matrix<double, 2, 3> ProjectionJacobian(const Camera& camera, const Eigen::Vector3d& X);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_IMAGE_PROJECTED_MESH_H_
