#include "client/io/format_readers.h"
#include "tests/client/io/expect_error.h"

namespace cagefit::client {
namespace {

constexpr char kVertices[] = "v 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\n";

absl::StatusOr<Geometry> Read(const std::string& text) { return ReadObj(text, {}, nullptr); }

TEST(ObjReaderTest, ReadsFacesOfAnyCornerFormAndSkipsTheRest) {
  const auto geometry =
      Read(std::string(kVertices) +
           "vt 0 0\nvn 0 0 1\no thing\nusemtl red\nl 1 2\nf 1/1/1 2//1 3//1\nf -4//1 "
           "-2//1 \\\n-1//1 # done\n");
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.triangles.col(0), Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(geometry->mesh.triangles.col(1), Eigen::Vector3i(0, 2, 3));
  ASSERT_EQ(geometry->normals.cols(), 4);
  EXPECT_EQ(geometry->normals.col(2), Eigen::Vector3f(0, 0, 1));
}

TEST(ObjReaderTest, ANormalIsTheMeanOfTheCorners) {
  const auto geometry =
      Read(std::string(kVertices) + "vn 1 0 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf 1//2 3//2 4//2\n");
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_TRUE(geometry->normals.col(0).isApprox(Eigen::Vector3f(1, 0, 1).normalized()));
  EXPECT_TRUE(geometry->normals.col(3).isApprox(Eigen::Vector3f(0, 0, 1)));
}

TEST(ObjReaderTest, SomeCornersWithoutNormalMeanNone) {
  const auto geometry = Read(std::string(kVertices) + "vn 1 0 0\nf 1//1 2//1 3\n");
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->normals.cols(), 0);
}

TEST(ObjReaderTest, PointsWithNormalsAreACloud) {
  const auto geometry = Read("v 1 2 3\nvn 0 0 2\nv 4 5 6\nvn 0 1 0\n");
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_TRUE(geometry->is_cloud());
  EXPECT_EQ(geometry->normals.col(0), Eigen::Vector3f(0, 0, 1));
}

TEST(ObjReaderTest, ReadsCreasesAndCornersFromComments) {
  CreaseTags tags;
  const auto geometry =
      ReadObj(std::string("# cagefit crease 1 2\n# cagefit corner 3\n") + kVertices + "f 1 2 3\n",
              {}, &tags);
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  ASSERT_EQ(tags.edges.size(), 1u);
  EXPECT_EQ(tags.edges[0], (std::array<int32_t, 2>{0, 1}));
  EXPECT_THAT(tags.corners, ::testing::ElementsAre(2));
}

TEST(ObjReaderTest, SaysWhichLineIsWrong) {
  EXPECT_INVALID(Read("v 1 2\n"), "line 1 is \"v 1 2\"");
  EXPECT_INVALID(Read("v 1 2 nan\n"), "vertex 0 (from 0) is not finite");
  EXPECT_INVALID(Read(std::string(kVertices) + "f 1 2 5\n"), "names vertex 4 (from 0) of 4");
  EXPECT_INVALID(Read(std::string(kVertices) + "f 1 2 0\n"), "line 5 is");
  EXPECT_INVALID(Read(std::string(kVertices) + "f 1 2 -5\n"), "line 5 is");
  EXPECT_INVALID(Read(std::string(kVertices) + "f 1 2 x\n"), "line 5 is");
  EXPECT_INVALID(Read(std::string(kVertices) + "f 1//1 2//1 3//1\n"), "names normal 1 of 0");
  // Of a face that is no triangle, too: its normals are added up.
  EXPECT_INVALID(Read("v 0 0 0\nvn 0 0 1\nf 900//1 1//1\n"), "line 3 names vertex 900 of 1");
  EXPECT_INVALID(Read("# cagefit crease 1\nv 0 0 0\n"), "line 1 is");
  EXPECT_INVALID(Read("# cagefit crease 1 9\nv 0 0 0\n"), "names vertex 9 of 1");
  EXPECT_INVALID(Read("# nothing\n"), "no vertices");
}

}  // namespace
}  // namespace cagefit::client
