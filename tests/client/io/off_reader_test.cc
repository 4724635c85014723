#include "client/io/format_readers.h"
#include "tests/client/io/expect_error.h"

namespace cagefit::client {
namespace {

absl::StatusOr<Geometry> Read(const std::string& text) { return ReadOff(text, {}); }

TEST(OffReaderTest, ReadsColoursCommentsAndPolygons) {
  const auto geometry = Read(
      "# first\nCOFF 4 1 # no edges\n\n0 0 0 255 0 0\n1 0 0 1 0 0#red\n1 1 0\n0 1 0\n4 0 1 2 3 0.5 "
      "0.5 0.5\n");
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->polygons, 1);
  EXPECT_EQ(geometry->mesh.triangles.cols(), 2);
}

TEST(OffReaderTest, ReadsNormals) {
  const auto geometry = Read("NOFF\n1 0 0\n1 2 3 0 1 0\n");
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->normals.col(0), Eigen::Vector3f(0, 1, 0));
}

TEST(OffReaderTest, SaysWhatIsWrong) {
  EXPECT_INVALID(Read("PLY\n"), "line 1 is \"PLY\"; expected OFF");
  EXPECT_INVALID(Read("OFF BINARY\n"), "binary OFF is not read");
  EXPECT_INVALID(Read("OFF\n3\n"), "the numbers of vertices");
  EXPECT_INVALID(Read("OFF\n1000000 1 0\n0 0 0\n"), "cannot hold them");
  // Two counts whose sum is beyond 64 bits.
  EXPECT_INVALID(Read("OFF\n8009866000402031290 8009866000402031290 0\n"), "cannot hold them");
  EXPECT_INVALID(Read("OFF\n2 0 0\n0 0 0\n"), "ends at vertex 1 (from 0) of 2");
  EXPECT_INVALID(Read("OFF\n1 0 0\n0 0\n#####\n"), "line 3 is \"0 0\"; expected vertex 0");
  EXPECT_INVALID(Read("OFF\n1 1 0\n0 0 0\n3 0 0\n"), "expected face 0");
  EXPECT_INVALID(Read("OFF\n1 1 0\n0 0 0\n3 0 0 7\n"), "names vertex 7 (from 0) of 1");
}

}  // namespace
}  // namespace cagefit::client
