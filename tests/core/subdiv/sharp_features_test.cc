#include "core/subdiv/sharp_features.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/subdiv/subdiv_samples.h"
#include "tests/support/shapes.h"

namespace cagefit {
namespace {

using ::testing::Each;

// Rows of six: 0 to 5 below, 30 to 35 above; 7 to 10, 13 to 16, ... inside.
class SharpFeaturesTest : public ::testing::Test {
 protected:
  VertexRule RuleOf(int32_t v, const CreaseTags& tags) const {
    return FindSharpFeatures(grid_, tags).vertex_rule[v];
  }
  const Topology grid_ = testing::TopologyOf(testing::OpenGrid(5));
};

TEST_F(SharpFeaturesTest, AClosedMeshWithoutTagsHasNone) {
  const Topology torus = testing::TopologyOf(testing::Torus(9, 7));
  const SharpFeatures sharp = FindSharpFeatures(torus, {});
  EXPECT_EQ(sharp.sharp_edge.size(), torus.edge_count());
  EXPECT_THAT(sharp.sharp_edge, Each(0));
  EXPECT_EQ(sharp.vertex_rule.size(), torus.vertex_count());
  EXPECT_THAT(sharp.vertex_rule, Each(VertexRule::kSmooth));
}

TEST_F(SharpFeaturesTest, BoundaryEdgesAreSharpAndNoOthers) {
  const SharpFeatures sharp = FindSharpFeatures(grid_, {});
  EXPECT_EQ(std::count(sharp.sharp_edge.begin(), sharp.sharp_edge.end(), 1), 20);
  for (int32_t e = 0; e < grid_.edge_count(); ++e) {
    EXPECT_EQ(sharp.sharp_edge[e] != 0, grid_.IsBoundaryEdge(e)) << "edge " << e;
  }
}

TEST_F(SharpFeaturesTest, BoundaryVerticesAreCreasesWhateverTheirNumberOfFaces) {
  const SharpFeatures sharp = FindSharpFeatures(grid_, {});
  for (int32_t v = 0; v < grid_.vertex_count(); ++v) {
    EXPECT_EQ(sharp.vertex_rule[v],
              grid_.IsBoundaryVertex(v) ? VertexRule::kCrease : VertexRule::kSmooth)
        << "vertex " << v;
  }
}

TEST_F(SharpFeaturesTest, TagsNameEdgesInEitherOrder) {
  const SharpFeatures sharp = FindSharpFeatures(grid_, {{{7, 8}, {15, 14}}, {}});
  EXPECT_TRUE(sharp.sharp_edge[grid_.FindEdge(7, 8)]);
  EXPECT_TRUE(sharp.sharp_edge[grid_.FindEdge(14, 15)]);
  EXPECT_FALSE(sharp.sharp_edge[grid_.FindEdge(8, 9)]);
}

TEST_F(SharpFeaturesTest, OneSharpEdgeMakesADart) {
  EXPECT_EQ(RuleOf(8, {{{7, 8}}, {}}), VertexRule::kSmooth);
}

TEST_F(SharpFeaturesTest, TwoSharpEdgesMakeACrease) {
  EXPECT_EQ(RuleOf(8, {{{7, 8}, {8, 9}}, {}}), VertexRule::kCrease);
}

TEST_F(SharpFeaturesTest, ThreeSharpEdgesMakeACorner) {
  EXPECT_EQ(RuleOf(8, {{{7, 8}, {8, 9}, {8, 14}}, {}}), VertexRule::kCorner);
}

TEST_F(SharpFeaturesTest, ACreaseThatMeetsTheBoundaryMakesACorner) {
  EXPECT_EQ(RuleOf(6, {{{6, 7}}, {}}), VertexRule::kCorner);
}

TEST_F(SharpFeaturesTest, ATagMakesACornerOfAnyVertex) {
  EXPECT_EQ(RuleOf(0, {{}, {0}}), VertexRule::kCorner);
  EXPECT_EQ(RuleOf(14, {{}, {14}}), VertexRule::kCorner);
  EXPECT_EQ(RuleOf(14, {{{13, 14}, {14, 15}}, {14}}), VertexRule::kCorner);
}

TEST_F(SharpFeaturesTest, ABoundaryEdgeTaggedAsWellCountsOnce) {
  EXPECT_EQ(RuleOf(1, {{{0, 1}, {1, 0}}, {}}), VertexRule::kCrease);
}

}  // namespace
}  // namespace cagefit
