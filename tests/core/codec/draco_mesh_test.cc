#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/codec/draco_codec.h"
#include "tests/core/codec/draco_samples.h"

namespace cagefit {
namespace {

using ::testing::HasSubstr;

TEST(DracoMeshTest, KeepsFloatsAndTheOrderOfVerticesAndTriangles) {
  const TriangleMesh grid = testing::WavyGrid(40);
  const auto decoded = DecodeDracoMesh(EncodeDracoMesh(grid, {}).value(), {});
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->triangles, grid.triangles);
  EXPECT_EQ(decoded->vertices.cast<float>(), grid.vertices.cast<float>());
}

TEST(DracoMeshTest, QuantizesWithinHalfAGridStep) {
  const TriangleMesh grid = testing::WavyGrid(20);
  for (int bits = 1; bits <= 30; ++bits) {
    DracoMeshOptions options;
    options.position_bits = bits;
    const auto decoded = DecodeDracoMesh(EncodeDracoMesh(grid, options).value(), {});
    ASSERT_TRUE(decoded.ok()) << bits << ": " << decoded.status();
    EXPECT_EQ(decoded->triangles, grid.triangles);
    const double step = 19.0 / ((int64_t{1} << bits) - 1);
    EXPECT_LE((decoded->vertices - grid.vertices).cwiseAbs().maxCoeff(), 0.51 * step + 4e-6)
        << bits;
  }
}

TEST(DracoMeshTest, RefusesAMeshThatIsNotValid) {
  const TriangleMesh grid = testing::WavyGrid(3);
  const auto message = [](const TriangleMesh& mesh, DracoMeshOptions options) {
    const absl::Status status = EncodeDracoMesh(mesh, options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  TriangleMesh bad = grid;
  bad.triangles(1, 2) = 9;
  EXPECT_THAT(message(bad, {}), HasSubstr("indices 0 to 9 for 9 vertices"));
  bad = grid;
  bad.vertices(0, 4) = HUGE_VAL;
  EXPECT_THAT(message(bad, {}), HasSubstr("not finite"));
  bad = grid;
  bad.vertices(0, 4) = 1e39;
  EXPECT_THAT(message(bad, {}), HasSubstr("not finite as 32-bit floats"));
  bad.triangles.resize(3, 0);
  EXPECT_THAT(message(bad, {}), HasSubstr("none to encode"));
  EXPECT_THAT(message(grid, {31, 7}), HasSubstr("position_bits is 31"));
  EXPECT_THAT(message(grid, {0, -1}), HasSubstr("speed is -1"));
}

TEST(DracoMeshTest, ReadsEdgebreakerMeshesWithTheirNormals) {
  const TriangleMesh grid = testing::WavyGrid(9);
  Points3f normals;
  const auto decoded =
      DecodeDracoMesh(testing::EdgebreakerBytes(grid, {true, true, false}), {}, &normals);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->vertices.cols(), 81);
  EXPECT_EQ(decoded->triangles.cols(), 128);
  ASSERT_EQ(normals.cols(), 81);
  EXPECT_GT(normals.row(2).minCoeff(), 0.999f);
}

TEST(DracoMeshTest, ReadsACloudAsAMeshWithoutTriangles) {
  PointCloud cloud;
  cloud.points = Points3f::Random(3, 30);
  Points3f normals;
  const auto decoded = DecodeDracoMesh(EncodeDracoCloud(cloud, {}).value(), {}, &normals);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->vertices.cols(), 30);
  EXPECT_EQ(decoded->triangles.cols(), 0);
  EXPECT_EQ(normals.cols(), 0);
}

}  // namespace
}  // namespace cagefit
