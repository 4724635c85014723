#include "core/fit/ceres_costs.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "core/energy/rotation.h"

namespace cagefit {

namespace {

Eigen::Map<const Eigen::Vector3d> Block(double const* const* parameters, size_t k) {
  return Eigen::Map<const Eigen::Vector3d>(parameters[k]);
}

Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d M;
  M << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return M;
}

// t with t^2 = rho(r^2) and the sign of r; writes dt/dr.
double RobustResidual(const RobustKernel& kernel, double r, double* slope) {
  double weight = 1;
  const double magnitude = std::sqrt(kernel.Rho(r * r, &weight));
  *slope = magnitude > 0 ? weight * std::abs(r) / magnitude : 1;
  return std::copysign(magnitude, r);
}

}  // namespace

SampleCost::SampleCost(const DistanceTerm& distance, int64_t sample, std::vector<double> stencil)
    : distance_(distance), sample_(sample), stencil_(std::move(stencil)) {
  set_num_residuals(2);
  mutable_parameter_block_sizes()->assign(stencil_.size(), 3);
}

bool SampleCost::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < stencil_.size(); ++k) x += stencil_[k] * Block(parameters, k);
  const SampleResiduals r = distance_.EvaluateSample(sample_, x);
  const double root = std::sqrt(distance_.weight());
  double slope = 1;
  residuals[0] = root * RobustResidual(distance_.kernel(), r.f, &slope);
  residuals[1] = root * r.beyond;
  if (jacobians == nullptr) return true;
  // J_r_Vk = sqrt(n/m) grad r^T dx/dV_k with dx/dV_k = s_k I.
  for (size_t k = 0; k < stencil_.size(); ++k) {
    if (jacobians[k] == nullptr) continue;
    Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> J_r_Vk(jacobians[k]);
    J_r_Vk.row(0) = root * slope * stencil_[k] * r.grad_f.transpose();
    J_r_Vk.row(1) = root * stencil_[k] * r.grad_beyond.transpose();
  }
  return true;
}

CoverageCost::CoverageCost(const CoverageTerm::Row& row, const RobustKernel& kernel,
                           std::vector<double> stencil)
    : row_(row), kernel_(kernel), stencil_(std::move(stencil)) {
  set_num_residuals(1);
  mutable_parameter_block_sizes()->assign(stencil_.size(), 3);
}

bool CoverageCost::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  Eigen::Vector3d X = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < stencil_.size(); ++k) X += stencil_[k] * Block(parameters, k);
  const double root = std::sqrt(row_.scale);
  double slope = 1;
  residuals[0] = root * RobustResidual(kernel_, row_.direction.dot(row_.target - X), &slope);
  if (jacobians == nullptr) return true;
  for (size_t k = 0; k < stencil_.size(); ++k) {
    if (jacobians[k] == nullptr) continue;
    Eigen::Map<Eigen::RowVector3d> J_r_Vk(jacobians[k]);
    J_r_Vk = -root * slope * stencil_[k] * row_.direction.transpose();
  }
  return true;
}

AttachmentCost::AttachmentCost(const Eigen::Matrix3d& weight, const Eigen::Vector3d& target,
                               std::vector<double> stencil)
    : target_(target), stencil_(std::move(stencil)) {
  // Rounding may have put an eigenvalue below 0.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(weight);
  root_ = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal() *
          eigen.eigenvectors().transpose();
  set_num_residuals(3);
  mutable_parameter_block_sizes()->assign(stencil_.size(), 3);
}

bool AttachmentCost::Evaluate(double const* const* parameters, double* residuals,
                              double** jacobians) const {
  Eigen::Vector3d X = -target_;
  for (size_t k = 0; k < stencil_.size(); ++k) X += stencil_[k] * Block(parameters, k);
  Eigen::Map<Eigen::Vector3d> r(residuals);
  r = root_ * X;
  if (jacobians == nullptr) return true;
  for (size_t k = 0; k < stencil_.size(); ++k) {
    if (jacobians[k] == nullptr) continue;
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> J(jacobians[k]);
    J = stencil_[k] * root_;
  }
  return true;
}

ArapCost::ArapCost(const ArapTerm& arap, int32_t vertex, double alpha)
    : arap_(arap), vertex_(vertex), alpha_(alpha) {
  const int neighbors = arap.begin(vertex + 1) - arap.begin(vertex);
  set_num_residuals(3 * neighbors);
  mutable_parameter_block_sizes()->assign(neighbors + 1, 3);
}

bool ArapCost::Evaluate(double const* const* parameters, double* residuals,
                        double** jacobians) const {
  const int32_t begin = arap_.begin(vertex_);
  const int neighbors = arap_.begin(vertex_ + 1) - begin;
  const auto rest_edge = [&](int k) -> Eigen::Vector3d {
    return arap_.rest().col(vertex_) - arap_.rest().col(arap_.neighbor(begin + k));
  };
  const auto edge = [&](int k) -> Eigen::Vector3d {
    return Block(parameters, 0) - Block(parameters, k + 1);
  };
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (int k = 0; k < neighbors; ++k) {
    C += arap_.weight(begin + k) * edge(k) * rest_edge(k).transpose();
  }
  const Eigen::Matrix3d R = BestRotation(C, Eigen::Matrix3d::Identity());
  for (int k = 0; k < neighbors; ++k) {
    const double root = std::sqrt(alpha_ * arap_.weight(begin + k));
    Eigen::Map<Eigen::Vector3d>(residuals + 3 * k) = root * (edge(k) - R * rest_edge(k));
  }
  if (jacobians == nullptr) return true;

  // dr_k = sqrt(alpha w_k) (dx_i - dx_k - w x e_k),  w = A^-1 sum_l w_l e_l x (dx_i - dx_l).
  const Eigen::Matrix3d inverse_inertia = R * arap_.inverse_inertia(vertex_) * R.transpose();
  Eigen::Matrix3d weighted_sum = Eigen::Matrix3d::Zero();
  for (int l = 0; l < neighbors; ++l) {
    weighted_sum += arap_.weight(begin + l) * CrossMatrix(R * rest_edge(l));
  }
  for (int block = 0; block <= neighbors; ++block) {
    if (jacobians[block] == nullptr) continue;
    const Eigen::Matrix3d turn = block == 0 ? (inverse_inertia * weighted_sum).eval()
                                            : (-inverse_inertia * arap_.weight(begin + block - 1) *
                                               CrossMatrix(R * rest_edge(block - 1)))
                                                  .eval();
    for (int k = 0; k < neighbors; ++k) {
      const double root = std::sqrt(alpha_ * arap_.weight(begin + k));
      Eigen::Matrix3d J = CrossMatrix(R * rest_edge(k)) * turn;  // -(w x e) = e x w
      if (block == 0) J += Eigen::Matrix3d::Identity();
      if (block == k + 1) J -= Eigen::Matrix3d::Identity();
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(jacobians[block] + 9 * k) = root * J;
    }
  }
  return true;
}

}  // namespace cagefit
