#include "client/synth/shape.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/mesh/topology.h"

namespace cagefit::client {
namespace {

class ShapeTest : public ::testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<SynthShape> Make(uint64_t seed) {
    auto shape = MakeShape(GetParam(), seed);
    EXPECT_TRUE(shape.ok()) << shape.status();
    return *std::move(shape);
  }
};

TEST_P(ShapeTest, IsManifoldWithTheBoundariesOfItsKind) {
  const TriangleMesh rest = Make(1)->rest();
  const auto topology =
      Topology::Create(static_cast<int32_t>(rest.vertices.cols()), rest.triangles);
  ASSERT_TRUE(topology.ok()) << topology.status();
  EXPECT_EQ(topology->BoundaryLoops().size(), GetParam() == "tube" ? 2u : 0u);
}

TEST_P(ShapeTest, MovesAsMuchAsACaptureDoes) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const auto shape = Make(seed);
    const Points3d before = shape->Vertices(0), after = shape->Vertices(1.0 / 60);
    const double step = (after - before).colwise().norm().mean();
    const double diagonal = BoundingBox(before).diagonal();
    EXPECT_GT(step, 0.002 * diagonal) << seed;
    EXPECT_LT(step, 0.03 * diagonal) << seed;
  }
}

TEST_P(ShapeTest, ReturnsAfterAPeriod) {
  const auto shape = Make(2);
  EXPECT_LT((shape->Vertices(1) - shape->Vertices(0)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_P(ShapeTest, NormalsAgreeWithTheMovedMesh) {
  const auto shape = Make(3);
  const double time = 0.2;
  const TriangleMesh moved = {shape->Vertices(time), shape->rest().triangles};
  const Points3d normals = VertexNormals(moved);
  double least = 1;
  for (int64_t v = 0; v < moved.vertices.cols(); ++v) {
    const SurfacePoint rest = shape->OnRest(shape->rest().vertices.col(v));
    const SurfacePoint point = shape->MovePoint(rest, time);
    EXPECT_LT((point.position - moved.vertices.col(v)).norm(), 1e-9);
    least = std::min(least, point.normal.dot(normals.col(v)));
  }
  EXPECT_GT(least, 0.9);  // at the rims the mesh knows one side only
}

TEST_P(ShapeTest, DetailsVaryWithTheSeed) {
  EXPECT_GT((Make(1)->Vertices(0) - Make(2)->Vertices(0)).colwise().norm().mean(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(All, ShapeTest, ::testing::ValuesIn(ShapeNames()));

TEST(MakeShapeTest, NamesTheShapesThatThereAre) {
  const auto shape = MakeShape("cube", 1);
  EXPECT_EQ(shape.status().message(), "shape is \"cube\"; expected tube or blob");
}

}  // namespace
}  // namespace cagefit::client
