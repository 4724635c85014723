#include "core/energy/attachments.h"

namespace cagefit {

Eigen::Vector3d Attachments::Residual(int64_t k, const Points3d& V) const {
  Eigen::Vector3d r = -targets.col(k);
  for (StencilMatrix::InnerIterator s(rows, k); s; ++s) r += s.value() * V.col(s.col());
  return r;
}

double Attachments::Energy(const Points3d& V) const {
  double sum = 0;
  for (int64_t k = 0; k < size(); ++k) {
    const Eigen::Vector3d r = Residual(k, V);
    sum += r.dot(weights[k] * r);
  }
  return sum;
}

void Attachments::AddHalfGradient(const Points3d& V, Points3d* half_gradient) const {
  for (int64_t k = 0; k < size(); ++k) {
    const Eigen::Vector3d g = weights[k] * Residual(k, V);
    for (StencilMatrix::InnerIterator s(rows, k); s; ++s)
      half_gradient->col(s.col()) += s.value() * g;
  }
}

}  // namespace cagefit
