#include "core/subdiv/stencils.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <vector>

#include "core/base/parallel.h"

namespace cagefit {

namespace {

constexpr int64_t kRowsPerChunk = 2048;

// Sum of weighted rows of a matrix. Dense over all columns; only the touched ones are ever cleared.
class RowSum {
 public:
  explicit RowSum(int64_t columns) : weight_(columns, 0.0), touched_(columns, 0) {}

  // Number of columns of the sum over the rows that `outer_row` names.
  int32_t Count(const StencilMatrix& outer, int64_t outer_row, const StencilMatrix& inner) {
    for (StencilMatrix::InnerIterator o(outer, outer_row); o; ++o) {
      for (StencilMatrix::InnerIterator s(inner, o.col()); s; ++s) {
        if (touched_[s.col()]) continue;
        touched_[s.col()] = 1;
        columns_.push_back(s.col());
      }
    }
    const auto count = static_cast<int32_t>(columns_.size());
    for (const int32_t column : columns_) touched_[column] = 0;
    columns_.clear();
    return count;
  }

  // Writes the sum, sorted by column.
  void Write(const StencilMatrix& outer, int64_t outer_row, const StencilMatrix& inner,
             int32_t* columns, double* weights) {
    for (StencilMatrix::InnerIterator o(outer, outer_row); o; ++o) {
      for (StencilMatrix::InnerIterator s(inner, o.col()); s; ++s) {
        if (!touched_[s.col()]) columns_.push_back(s.col());
        touched_[s.col()] = 1;
        weight_[s.col()] += o.value() * s.value();
      }
    }
    std::sort(columns_.begin(), columns_.end());
    for (const int32_t column : columns_) {
      *columns++ = column;
      *weights++ = weight_[column];
      weight_[column] = 0;
      touched_[column] = 0;
    }
    columns_.clear();
  }

 private:
  std::vector<double> weight_;
  std::vector<char> touched_;
  std::vector<int32_t> columns_;
};

}  // namespace

void ApplyStencils(const StencilMatrix& S, const Points3d& V, Points3d* samples) {
  samples->resize(3, S.rows());
  // A product this small is over before a second thread wakes.
  ParallelFor(S.rows(), 16 * kRowsPerChunk, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      Eigen::Vector3d q = Eigen::Vector3d::Zero();
      for (StencilMatrix::InnerIterator s(S, i); s; ++s) q += s.value() * V.col(s.col());
      samples->col(i) = q;
    }
  });
}

StencilMatrix ComposeStencils(const StencilMatrix& outer, const StencilMatrix& inner) {
  const int64_t rows = outer.rows();
  StencilMatrix product(rows, inner.cols());
  int32_t* begin = product.outerIndexPtr();
  tbb::enumerable_thread_specific<RowSum> sums([&] { return RowSum(inner.cols()); });
  // Counting first costs less than buffers that grow.
  ParallelFor(rows, kRowsPerChunk, [&](int64_t first, int64_t last) {
    RowSum& sum = sums.local();
    for (int64_t i = first; i < last; ++i) begin[i + 1] = sum.Count(outer, i, inner);
  });
  begin[0] = 0;
  for (int64_t i = 0; i < rows; ++i) begin[i + 1] += begin[i];
  product.resizeNonZeros(begin[rows]);
  ParallelFor(rows, kRowsPerChunk, [&](int64_t first, int64_t last) {
    RowSum& sum = sums.local();
    for (int64_t i = first; i < last; ++i) {
      sum.Write(outer, i, inner, product.innerIndexPtr() + begin[i], product.valuePtr() + begin[i]);
    }
  });
  return product;
}

}  // namespace cagefit
