// Moves a surface as a whole onto a target, before it is fitted.
#ifndef CAGEFIT_CORE_FIT_ALIGNMENT_H_
#define CAGEFIT_CORE_FIT_ALIGNMENT_H_

#include "core/base/types.h"
#include "core/cloud/point_cloud.h"
#include "core/mesh/triangle_mesh.h"

namespace cagefit {

// x -> scale rotation x + translation.
struct Similarity {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const {
    return scale * (rotation * x) + translation;
  }
  Points3d operator*(const Points3d& X) const {
    return ((scale * rotation) * X).colwise() + translation;
  }
  Eigen::Vector3d Inverse(const Eigen::Vector3d& x) const {
    return rotation.transpose() * (x - translation) / scale;
  }
  bool is_identity() const { return scale == 1 && rotation.isIdentity(0) && translation.isZero(0); }
};

// Iterated closest points, both ways, point to plane [chen1992], under a Geman-McClure kernel that
// narrows step by step. Starts from where the surface is and from where its centroid and spread are
// those of the target, and takes the better end. The identity unless that halves the mean squared
// distance, each distance counted as 0.1 at most: a surface that is near only has to bend. Turns of
// more than some 40 degrees are not found.
//
// `target` has normals and lies in the unit box (normalization.h), `surface` in the same
// coordinates. Without triangles of positive area the answer is the identity.
Similarity AlignToTarget(const TriangleMesh& surface, const PointCloud& target);

// As AlignToTarget, for a surface of the target's own size and near it in shape: turns and shifts
// alone, from where the surface is or, where that is nearer, from where its centroid is the
// target's. Always what it came to: whether it helps is the caller's to say. Looks at 10,000 points
// of the target at most.
Similarity AlignRigidly(const TriangleMesh& surface, const PointCloud& target);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_FIT_ALIGNMENT_H_
