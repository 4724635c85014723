#include "client/io/format_readers.h"
#include "tests/client/io/expect_error.h"

namespace cagefit::client {
namespace {

TEST(XyzReaderTest, ReadsPointsWithAnySeparators) {
  const auto geometry =
      ReadXyz("3\n# cloud\n1 2 3\n4,5,6,0.7\n\n7; 8; 9 // last\nnan nan nan\n", {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.vertices.cols(), 3);
  EXPECT_EQ(geometry->mesh.vertices.col(2), Eigen::Vector3d(7, 8, 9));
  EXPECT_EQ(geometry->normals.cols(), 0);
}

TEST(XyzReaderTest, SixColumnsAreNormalsOnlyWhenAllAreUnitVectors) {
  const auto normals = ReadXyz("x y z nx ny nz\n1 2 3 0 0 1\n4 5 6 0 -0.6 0.8 17\n", {});
  ASSERT_TRUE(normals.ok()) << normals.status();
  ASSERT_EQ(normals->normals.cols(), 2);
  EXPECT_EQ(normals->normals.col(1), Eigen::Vector3f(0, -0.6f, 0.8f));
  const auto colours = ReadXyz("1 2 3 0 0 1\n4 5 6 128 64 255\n", {});
  ASSERT_TRUE(colours.ok()) << colours.status();
  EXPECT_EQ(colours->normals.cols(), 0);
}

TEST(XyzReaderTest, SaysWhichLineIsWrong) {
  EXPECT_INVALID(ReadXyz("1 2 3\n4 5\n", {}), "line 2 is \"4 5\"");
  EXPECT_INVALID(ReadXyz("x y z\nx y z\n", {}), "line 2 is");
  EXPECT_INVALID(ReadXyz("\n\n", {}), "no vertices");
}

}  // namespace
}  // namespace cagefit::client
