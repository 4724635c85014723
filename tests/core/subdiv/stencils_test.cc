#include "core/subdiv/stencils.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Core>
#include <algorithm>
#include <random>
#include <vector>

#include "core/subdiv/refine.h"
#include "tests/core/subdiv/subdiv_samples.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

// About `per_row` weights in most rows, none in some.
StencilMatrix RandomStencils(int64_t rows, int64_t columns, int per_row, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> weight(-1, 1);
  std::vector<Eigen::Triplet<double, int32_t>> entries;
  for (int64_t i = 0; i < rows; ++i) {
    if (random() % 8 == 0) continue;
    for (int k = 0; k < per_row; ++k) {
      entries.emplace_back(static_cast<int32_t>(i), static_cast<int32_t>(random() % columns),
                           weight(random));
    }
  }
  StencilMatrix matrix(rows, columns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

StencilMatrix ComposeWithThreads(int threads, const StencilMatrix& outer,
                                 const StencilMatrix& inner) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return ComposeStencils(outer, inner);
}

bool SameToTheBit(const StencilMatrix& a, const StencilMatrix& b) {
  const auto rows = static_cast<size_t>(a.rows()), entries = static_cast<size_t>(a.nonZeros());
  return a.rows() == b.rows() && a.cols() == b.cols() && a.nonZeros() == b.nonZeros() &&
         std::equal(a.outerIndexPtr(), a.outerIndexPtr() + rows + 1, b.outerIndexPtr()) &&
         std::equal(a.innerIndexPtr(), a.innerIndexPtr() + entries, b.innerIndexPtr()) &&
         std::equal(a.valuePtr(), a.valuePtr() + entries, b.valuePtr());
}

TEST(ApplyStencilsTest, IsTheProductWithTheTranspose) {
  // 70,000 rows are more than one thread's share.
  for (const int64_t rows : {int64_t{1}, int64_t{137}, int64_t{70000}}) {
    const StencilMatrix S = RandomStencils(rows, 40, 7, 1);
    const Points3d V = Points3d::Random(3, 40);
    Points3d samples;
    ApplyStencils(S, V, &samples);
    ASSERT_EQ(samples.cols(), rows);
    const Points3d expected = V * Eigen::MatrixXd(S).transpose();
    EXPECT_LT((samples - expected).cwiseAbs().maxCoeff(), 1e-14) << rows << " rows";
  }
}

TEST(ApplyStencilsTest, ARowWithoutWeightsGivesZero) {
  Points3d samples = Points3d::Constant(3, 5, 8);
  ApplyStencils(StencilMatrix(5, 4), Points3d::Ones(3, 4), &samples);
  EXPECT_EQ(samples, Points3d::Zero(3, 5));
}

TEST(ApplyStencilsTest, KeepsTheMemoryOfSamplesOfTheRightShape) {
  Points3d samples(3, 137);
  const double* data = samples.data();
  ApplyStencils(RandomStencils(137, 40, 7, 1), Points3d::Random(3, 40), &samples);
  EXPECT_EQ(samples.data(), data);
}

TEST(ComposeStencilsTest, IsTheProduct) {
  const StencilMatrix outer = RandomStencils(5000, 300, 6, 1);
  const StencilMatrix inner = RandomStencils(300, 60, 5, 2);
  const StencilMatrix product = ComposeStencils(outer, inner);
  ASSERT_EQ(product.rows(), 5000);
  ASSERT_EQ(product.cols(), 60);
  const Eigen::MatrixXd expected = Eigen::MatrixXd(outer) * Eigen::MatrixXd(inner);
  EXPECT_LT((Eigen::MatrixXd(product) - expected).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(ComposeStencilsTest, RowsNameEachColumnOnceInOrder) {
  const StencilMatrix product =
      ComposeStencils(RandomStencils(5000, 300, 6, 1), RandomStencils(300, 60, 5, 2));
  for (int64_t i = 0; i < product.rows(); ++i) {
    int32_t last = -1;
    for (StencilMatrix::InnerIterator s(product, i); s; ++s) {
      ASSERT_GT(s.col(), last) << "row " << i;
      last = s.col();
    }
  }
}

TEST(ComposeStencilsTest, DoesNotDependOnTheNumberOfThreads) {
  const Topology coarse = testing::TopologyOf(testing::MixedValences());
  const Refinement one = RefineOnce(coarse, {});
  const Refinement two = RefineOnce(one.topology, one.tags);
  const Refinement three = RefineOnce(two.topology, two.tags);
  ASSERT_GT(three.matrix.rows(), 3 * 2048);  // several chunks
  const StencilMatrix to_two = ComposeStencils(two.matrix, one.matrix);
  const StencilMatrix serial = ComposeWithThreads(1, three.matrix, to_two);
  for (int repeat = 0; repeat < 5; ++repeat) {
    EXPECT_TRUE(SameToTheBit(serial, ComposeWithThreads(2, three.matrix, to_two)));
  }
}

}  // namespace
}  // namespace cagefit
