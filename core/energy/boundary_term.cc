#include "core/energy/boundary_term.h"

#include <Eigen/Geometry>

#include "core/subdiv/limit_surface.h"

namespace cagefit {

namespace {

// A point of every boundary edge of the control mesh, at each of kPointsPerEdge equal steps.
std::vector<SurfacePoint> BoundaryPoints(const Topology& topology) {
  std::vector<SurfacePoint> points;
  const Triangles& triangles = topology.triangles();
  for (int32_t f = 0; f < triangles.cols(); ++f) {
    for (int c = 0; c < 3; ++c) {
      if (!topology.IsBoundaryEdge(topology.triangle_edge(f, c))) continue;
      for (int k = 0; k < BoundaryTerm::kPointsPerEdge; ++k) {
        Eigen::Vector3d corners = Eigen::Vector3d::Zero();
        corners[(c + 1) % 3] = static_cast<double>(k) / BoundaryTerm::kPointsPerEdge;
        corners[c] = 1 - corners[(c + 1) % 3];
        points.push_back({f, corners[1], corners[2]});
      }
    }
  }
  return points;
}

}  // namespace

BoundaryTerm::BoundaryTerm(const Topology& topology, const CreaseTags& tags) : topology_(topology) {
  const std::vector<SurfacePoint> points = BoundaryPoints(topology);
  if (points.empty()) return;
  auto stencils = LimitSurface(topology, tags).Stencils(points, Derivatives::kFirst);
  position_.swap(stencils->position);
  du_.swap(stencils->du);
  dv_.swap(stencils->dv);
}

void BoundaryTerm::SetTarget(const BoundaryCurve* curve, double weight) {
  if (curve == nullptr || curve->size() == 0 || weight <= 0 || position_.rows() == 0) {
    attachments_.Clear();
    return;
  }
  curve_ = curve;
  tree_.emplace(curve->points);
  weight_ = weight;
  const int64_t B = position_.rows();
  if (!is_on()) attachments_.rows = position_;
  attachments_.targets.setZero(3, B);
  attachments_.weights.assign(B, Eigen::Matrix3d::Zero());
}

void BoundaryTerm::Assign(const Points3d& V) {
  if (!is_on()) return;
  ApplyStencils(position_, V, &points_);
  ApplyStencils(du_, V, &tangents_u_);
  ApplyStencils(dv_, V, &tangents_v_);
  const int64_t B = position_.rows();
  const double share = weight_ * static_cast<double>(V.cols()) / static_cast<double>(B);
  const double reach = kReach * MeanEdgeLength(topology_, V);
  for (int64_t b = 0; b < B; ++b) {
    int32_t nearest = 0;
    float square = 0;
    const Eigen::Vector3d x = points_.col(b);
    tree_->Nearest(x.cast<float>(), 1, &nearest, &square);
    const Eigen::Vector3d normal = tangents_u_.col(b).cross(tangents_v_.col(b));
    const Eigen::Vector3d t = curve_->tangents.col(nearest).cast<double>();
    attachments_.targets.col(b) = curve_->points.col(nearest).cast<double>();
    const bool takes_part =
        square <= reach * reach && normal.dot(curve_->normals.col(nearest).cast<double>()) > 0;
    attachments_.weights[b] =
        takes_part ? (share * (Eigen::Matrix3d::Identity() - t * t.transpose())).eval()
                   : Eigen::Matrix3d::Zero().eval();
  }
}

}  // namespace cagefit
