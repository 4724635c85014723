#include "core/energy/arap_term.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>

#include "core/base/parallel.h"
#include "core/energy/rotation.h"

namespace cagefit {

namespace {

constexpr int64_t kGrain = 8192;  // vertices a chunk

// Inverse of the inertia tr(M) I - M of M = sum w e e^T. Directions about which nothing turns (all
// edges along one line) get 0: no rotation.
Eigen::Matrix3d InverseInertia(const Eigen::Matrix3d& M) {
  Eigen::Matrix3d A = -M;
  A.diagonal().array() += M.trace();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(A);
  const double least = 1e-9 * eigen.eigenvalues()[2];
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    if (eigen.eigenvalues()[k] > least) inverse[k] = 1 / eigen.eigenvalues()[k];
  }
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

ArapTerm::ArapTerm(const Topology& topology) : triangles_(topology.triangles()) {
  const int32_t n = topology.vertex_count();
  begin_.resize(n + 1, 0);
  for (int32_t i = 0; i < n; ++i) {
    const absl::Span<const int32_t> ring = topology.Ring(i);
    neighbor_.insert(neighbor_.end(), ring.begin(), ring.end());
    std::sort(neighbor_.begin() + begin_[i], neighbor_.end());
    begin_[i + 1] = static_cast<int32_t>(neighbor_.size());
  }
  const auto entry = [&](int32_t i, int32_t j) {
    const auto from = neighbor_.begin() + begin_[i], to = neighbor_.begin() + begin_[i + 1];
    return static_cast<int32_t>(std::lower_bound(from, to, j) - neighbor_.begin());
  };
  triangle_entry_.reserve(6 * triangles_.cols());
  for (int64_t f = 0; f < triangles_.cols(); ++f) {
    for (int c = 0; c < 3; ++c) {
      const int32_t a = triangles_(c, f), b = triangles_((c + 1) % 3, f);
      triangle_entry_.push_back(entry(a, b));
      triangle_entry_.push_back(entry(b, a));
    }
  }
  weight_.resize(neighbor_.size());
}

void ArapTerm::SetRest(const Points3d& rest) {
  rest_ = rest;
  std::fill(weight_.begin(), weight_.end(), 0.0);
  for (int64_t f = 0; f < triangles_.cols(); ++f) {
    for (int c = 0; c < 3; ++c) {
      // Edge (c, c + 1) is opposite corner c + 2.
      const Eigen::Vector3d apex = rest.col(triangles_((c + 2) % 3, f));
      const Eigen::Vector3d a = rest.col(triangles_(c, f)) - apex;
      const Eigen::Vector3d b = rest.col(triangles_((c + 1) % 3, f)) - apex;
      const double twice_area = a.cross(b).norm();
      const double half_cot = twice_area > 0 ? 0.5 * a.dot(b) / twice_area : 0.0;
      weight_[triangle_entry_[6 * f + 2 * c]] += half_cot;
      weight_[triangle_entry_[6 * f + 2 * c + 1]] += half_cot;
    }
  }
  for (double& w : weight_) w = std::max(w, kMinWeight);

  const int32_t n = vertex_count();
  rotation_.assign(n, Eigen::Matrix3d::Identity());
  inverse_inertia_.resize(n);
  for (int32_t i = 0; i < n; ++i) {
    Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
    for (int32_t k = begin_[i]; k < begin_[i + 1]; ++k) {
      const Eigen::Vector3d e = rest.col(i) - rest.col(neighbor_[k]);
      M += weight_[k] * e * e.transpose();
    }
    inverse_inertia_[i] = InverseInertia(M);
  }
}

void ArapTerm::UpdateRotations(const Points3d& V) {
  ParallelFor(vertex_count(), kGrain, [&](int64_t from, int64_t to) {
    for (int64_t i = from; i < to; ++i) {
      Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
      for (int32_t k = begin_[i]; k < begin_[i + 1]; ++k) {
        const int32_t j = neighbor_[k];
        C.noalias() +=
            (weight_[k] * (V.col(i) - V.col(j))) * (rest_.col(i) - rest_.col(j)).transpose();
      }
      rotation_[i] = BestRotation(C, rotation_[i]);
    }
  });
}

double ArapTerm::Evaluate(const Points3d& V, Points3d* half_gradient) const {
  if (half_gradient != nullptr) half_gradient->resize(3, V.cols());
  return ParallelSum(vertex_count(), kGrain, [&](int64_t from, int64_t to) {
    double sum = 0;
    for (int64_t i = from; i < to; ++i) {
      Eigen::Vector3d g = Eigen::Vector3d::Zero();
      for (int32_t k = begin_[i]; k < begin_[i + 1]; ++k) {
        const int32_t j = neighbor_[k];
        const Eigen::Vector3d e = V.col(i) - V.col(j);
        const Eigen::Vector3d rest_edge = rest_.col(i) - rest_.col(j);
        const Eigen::Vector3d r = e - rotation_[i] * rest_edge;
        sum += weight_[k] * r.squaredNorm();
        // The same edge seen from j adds e - R_j (V'_i - V'_j).
        g += weight_[k] * (r + e - rotation_[j] * rest_edge);
      }
      if (half_gradient != nullptr) half_gradient->col(i) = g;
    }
    return sum;
  });
}

}  // namespace cagefit
