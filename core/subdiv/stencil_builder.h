// Writes stencil matrices whose row sizes are known, row by row in parallel, straight into
// compressed form.
#ifndef CAGEFIT_CORE_SUBDIV_STENCIL_BUILDER_H_
#define CAGEFIT_CORE_SUBDIV_STENCIL_BUILDER_H_

#include <cstdint>
#include <utility>

#include "core/base/parallel.h"
#include "core/subdiv/stencils.h"

namespace cagefit {

// One row: entries in any order, kept sorted by column. Rows are a vertex or an edge and its ring,
// short enough for insertion.
class StencilRow {
 public:
  StencilRow(int32_t* columns, double* weights) : columns_(columns), weights_(weights) {}

  void Add(int32_t column, double weight) {
    int32_t k = size_++;
    for (; k > 0 && columns_[k - 1] > column; --k) {
      columns_[k] = columns_[k - 1];
      weights_[k] = weights_[k - 1];
    }
    columns_[k] = column;
    weights_[k] = weight;
  }

 private:
  int32_t* columns_;
  double* weights_;
  int32_t size_ = 0;
};

// A rows x columns matrix. `row_size(i)` is the number of entries that `fill(i, row)` adds to row
// i; both are called concurrently for different i.
template <typename RowSize, typename Fill>
StencilMatrix BuildStencils(int64_t rows, int64_t columns, const RowSize& row_size,
                            const Fill& fill) {
  constexpr int64_t kGrain = 4096;
  StencilMatrix matrix(rows, columns);
  int32_t* begin = matrix.outerIndexPtr();
  begin[0] = 0;
  for (int64_t i = 0; i < rows; ++i) begin[i + 1] = begin[i] + row_size(i);
  matrix.resizeNonZeros(begin[rows]);
  ParallelFor(rows, kGrain, [&](int64_t first, int64_t last) {
    for (int64_t i = first; i < last; ++i) {
      StencilRow row(matrix.innerIndexPtr() + begin[i], matrix.valuePtr() + begin[i]);
      fill(i, &row);
    }
  });
  return matrix;
}

}  // namespace cagefit

#endif  // CAGEFIT_CORE_SUBDIV_STENCIL_BUILDER_H_
