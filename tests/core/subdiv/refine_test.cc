#include "core/subdiv/refine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "tests/core/subdiv/opensubdiv_loop.h"
#include "tests/core/subdiv/subdiv_samples.h"

namespace cagefit {
namespace {

using testing::SubdivSample;
using ::testing::UnorderedElementsAre;

class RefineTest : public ::testing::TestWithParam<SubdivSample> {};
INSTANTIATE_TEST_SUITE_P(Samples, RefineTest, ::testing::ValuesIn(testing::SubdivSamples()),
                         [](const auto& info) { return info.param.name; });

double LargestDifference(const Points3d& a, const Points3d& b) {
  return a.cols() == b.cols() ? (a - b).colwise().norm().maxCoeff() : 1e300;
}

TEST_P(RefineTest, CountsFourTrianglesForOneAndAVertexForAnEdge) {
  const Topology& coarse = GetParam().topology;
  const Refinement fine = RefineOnce(coarse, GetParam().tags);
  EXPECT_EQ(fine.topology.vertex_count(), coarse.vertex_count() + coarse.edge_count());
  EXPECT_EQ(fine.topology.edge_count(), 2 * coarse.edge_count() + 3 * coarse.triangle_count());
  EXPECT_EQ(fine.topology.triangle_count(), 4 * coarse.triangle_count());
  EXPECT_EQ(fine.matrix.rows(), fine.topology.vertex_count());
  EXPECT_EQ(fine.matrix.cols(), coarse.vertex_count());
}

TEST_P(RefineTest, NumbersTheCornersFirstAndTheMiddleTriangleLast) {
  const Topology& coarse = GetParam().topology;
  const Triangles fine = SplitTriangles(coarse);
  ASSERT_EQ(fine.cols(), 4 * coarse.triangle_count());
  for (int32_t f = 0; f < coarse.triangle_count(); ++f) {
    const auto c = coarse.triangles().col(f);
    int32_t e[3];
    for (int k = 0; k < 3; ++k) {
      e[k] = coarse.vertex_count() + coarse.FindEdge(c[k], c[(k + 1) % 3]);
    }
    EXPECT_EQ(fine.col(4 * f), Eigen::Vector3i(c[0], e[0], e[2]));
    EXPECT_EQ(fine.col(4 * f + 1), Eigen::Vector3i(c[1], e[1], e[0]));
    EXPECT_EQ(fine.col(4 * f + 2), Eigen::Vector3i(c[2], e[2], e[1]));
    EXPECT_EQ(fine.col(4 * f + 3), Eigen::Vector3i(e[0], e[1], e[2]));
  }
}

TEST_P(RefineTest, KeepsValencesAndAddsRegularVertices) {
  const Topology& coarse = GetParam().topology;
  const Topology fine = RefineOnce(coarse, GetParam().tags).topology;
  for (int32_t v = 0; v < coarse.vertex_count(); ++v) EXPECT_EQ(fine.Valence(v), coarse.Valence(v));
  for (int32_t e = 0; e < coarse.edge_count(); ++e) {
    EXPECT_EQ(fine.Valence(coarse.vertex_count() + e), coarse.IsBoundaryEdge(e) ? 4 : 6);
  }
}

TEST_P(RefineTest, WeightsArePositiveAndSumToOne) {
  const StencilMatrix matrix = RefineOnce(GetParam().topology, GetParam().tags).matrix;
  for (int64_t i = 0; i < matrix.rows(); ++i) {
    double sum = 0;
    for (StencilMatrix::InnerIterator s(matrix, i); s; ++s) {
      EXPECT_GT(s.value(), 0);
      sum += s.value();
    }
    EXPECT_NEAR(sum, 1, 1e-15) << "vertex " << i;
  }
}

TEST_P(RefineTest, AgreesWithOpenSubdivAfterOneStep) {
  const SubdivSample& sample = GetParam();
  const testing::OpenSubdivLoop oracle(sample.topology, sample.tags, 1, 1);
  Points3d fine;
  ApplyStencils(RefineOnce(sample.topology, sample.tags).matrix, sample.V, &fine);
  EXPECT_LT(LargestDifference(fine, oracle.Refined(sample.V, 1)), 1e-14);
}

// The later steps depend on what the first made of the tags.
TEST_P(RefineTest, AgreesWithOpenSubdivAfterThreeSteps) {
  const SubdivSample& sample = GetParam();
  const testing::OpenSubdivLoop oracle(sample.topology, sample.tags, 3, 3);
  Refinement fine = RefineOnce(sample.topology, sample.tags);
  Points3d V = sample.V, finer;
  ApplyStencils(fine.matrix, V, &finer);
  for (int step = 2; step <= 3; ++step) {
    V = finer;
    fine = RefineOnce(fine.topology, fine.tags);
    ApplyStencils(fine.matrix, V, &finer);
  }
  EXPECT_LT(LargestDifference(finer, oracle.Refined(sample.V, 3)), 1e-14);
}

TEST_P(RefineTest, TheMatrixAloneIsTheSame) {
  const SubdivSample& sample = GetParam();
  const StencilMatrix alone =
      RefinementStencils(sample.topology, FindSharpFeatures(sample.topology, sample.tags));
  const Eigen::MatrixXd whole = RefineOnce(sample.topology, sample.tags).matrix;
  EXPECT_EQ(Eigen::MatrixXd(alone), whole);
}

TEST(RefineTagsTest, BothHalvesOfACreaseAreCreasesAndCornersStay) {
  const Topology grid = testing::SubdivSamples()[1].topology;
  const Refinement fine = RefineOnce(grid, {{{8, 7}}, {14, 0}});
  const int32_t middle = grid.vertex_count() + grid.FindEdge(7, 8);
  std::set<std::set<int32_t>> creases;
  for (const auto& [a, b] : fine.tags.edges) creases.insert({a, b});
  EXPECT_THAT(creases,
              UnorderedElementsAre(std::set<int32_t>{7, middle}, std::set<int32_t>{middle, 8}));
  EXPECT_THAT(fine.tags.corners, UnorderedElementsAre(14, 0));
}

}  // namespace
}  // namespace cagefit
