// Stencils: rows of sparse matrices that express points of the subdivision surface in the control
// vertices.
#ifndef CAGEFIT_CORE_SUBDIV_STENCILS_H_
#define CAGEFIT_CORE_SUBDIV_STENCILS_H_

#include <Eigen/SparseCore>
#include <cstdint>

#include "core/base/types.h"

namespace cagefit {

// One row per sample, one column per control vertex. Rows of position stencils sum to 1, of
// derivatives to 0.
using StencilMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor, int32_t>;

// Q = V S^T: samples (3 x m) from control vertices (3 x n). Resizes `samples` only when its shape
// differs.
void ApplyStencils(const StencilMatrix& S, const Points3d& V, Points3d* samples);

// The product `outer` * `inner`: samples of samples (m x k times k x n). The same to the bit for
// any number of threads.
StencilMatrix ComposeStencils(const StencilMatrix& outer, const StencilMatrix& inner);

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_STENCILS_H_
