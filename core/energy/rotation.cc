#include "core/energy/rotation.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

namespace cagefit {

namespace {

Eigen::Matrix3d RotationBySvd(const Eigen::Matrix3d& C) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) *= -1;  // least singular value
  return U * svd.matrixV().transpose();
}

// exp([w]x) to second order, made orthogonal by the Cayley map.
Eigen::Matrix3d SmallRotation(const Eigen::Vector3d& w) {
  Eigen::Quaterniond q(1, w.x() / 2, w.y() / 2, w.z() / 2);
  return q.normalized().toRotationMatrix();
}

}  // namespace

Eigen::Matrix3d BestRotation(const Eigen::Matrix3d& C, const Eigen::Matrix3d& guess) {
  constexpr int kMaxNewtonSteps = 6;
  constexpr double kTolerance = 1e-14;
  const double scale = C.cwiseAbs().sum();
  if (!(scale > 0)) return guess;
  Eigen::Matrix3d R = guess;
  for (int step = 0; step < kMaxNewtonSteps; ++step) {
    // With M = C R^T: d tr(M e^-[w]) = w . axial(M),  second derivative -(tr(M) I - sym(M)).
    const Eigen::Matrix3d M = C * R.transpose();
    const Eigen::Vector3d axial(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1));
    Eigen::Matrix3d H = -0.5 * (M + M.transpose());
    H.diagonal().array() += M.trace();
    // tr(R^T C) has one maximum on SO(3); H is positive definite there and not at its other
    // critical points.
    const double minor2 = H(0, 0) * H(1, 1) - H(0, 1) * H(0, 1);
    const double determinant = H.determinant();
    const double tiny = 1e-9 * scale;
    if (!(H(0, 0) > tiny && minor2 > tiny * scale && determinant > tiny * scale * scale)) break;
    if (axial.squaredNorm() <= kTolerance * kTolerance * scale * scale) return R;
    R = SmallRotation(H.inverse() * axial) * R;
  }
  return RotationBySvd(C);
}

}  // namespace cagefit
