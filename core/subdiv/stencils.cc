#include "core/subdiv/stencils.h"

#include "core/base/parallel.h"

namespace cagefit {

void ApplyStencils(const StencilMatrix& S, const Points3d& V, Points3d* samples) {
  samples->resize(3, S.rows());
  ParallelFor(S.rows(), 4096, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      Eigen::Vector3d q = Eigen::Vector3d::Zero();
      for (StencilMatrix::InnerIterator s(S, i); s; ++s) q += s.value() * V.col(s.col());
      samples->col(i) = q;
    }
  });
}

}  // namespace cagefit
