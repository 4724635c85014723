#include <cstring>

#include "client/io/format_readers.h"
#include "tests/client/io/expect_error.h"

namespace cagefit::client {
namespace {

constexpr char kTriangle[] =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 3\nproperty float x\nproperty "
    "float "
    "y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(PlyReaderTest, ReadsText) {
  const auto geometry = ReadPly(kTriangle, {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.vertices.col(1), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(geometry->mesh.triangles.col(0), Eigen::Vector3i(0, 1, 2));
}

TEST(PlyReaderTest, CutsPolygonsIntoFansAndSkipsOtherElements) {
  const auto geometry = ReadPly(
      "ply\nformat ascii 1.0\nelement camera 2\nproperty float a\nproperty list uchar float b\n"
      "element vertex 4\nproperty uchar red\nproperty double z\nproperty double y\nproperty double "
      "x\n"
      "element face 1\nproperty uchar flags\nproperty list uint8 uint32 vertex_index\nend_header\n"
      "7 2 1 2\n8 0\n255 3 2 1\n255 0 0 1\n255 0 1 1\n255 0 1 0\n9 4 0 1 2 3\n",
      {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.vertices.col(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(geometry->polygons, 1);
  EXPECT_EQ(geometry->mesh.triangles.col(1), Eigen::Vector3i(0, 2, 3));
}

template <typename Value>
void Append(Value value, bool big_endian, std::string* bytes) {
  char raw[sizeof(Value)];
  std::memcpy(raw, &value, sizeof(Value));
  if (big_endian) std::reverse(raw, raw + sizeof(Value));
  bytes->append(raw, sizeof(Value));
}

TEST(PlyReaderTest, ReadsBothByteOrders) {
  for (const bool big : {false, true}) {
    std::string bytes =
        std::string("ply\nformat binary_") + (big ? "big" : "little") +
        "_endian 1.0\nelement vertex 1\nproperty short x\nproperty double y\n"
        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
        "end_header\n";
    Append<int16_t>(-300, big, &bytes);
    Append<double>(0.1, big, &bytes);
    for (const float value : {2.5f, 0.0f, 0.0f, -1.0f}) Append(value, big, &bytes);
    const auto geometry = ReadPly(bytes, {});
    ASSERT_TRUE(geometry.ok()) << geometry.status();
    EXPECT_EQ(geometry->mesh.vertices.col(0), Eigen::Vector3d(-300, 0.1, 2.5));
    EXPECT_EQ(geometry->normals.col(0), Eigen::Vector3f(0, 0, -1));
  }
}

TEST(PlyReaderTest, KeepsADataByteThatLooksLikeALineEnd) {
  std::string bytes =
      "ply\rformat binary_little_endian 1.0\relement vertex 1\rproperty uchar x\rproperty uchar y\r"
      "property uchar z\rend_header\r\n\x01\x02";
  const auto geometry = ReadPly(bytes, {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.vertices.col(0), Eigen::Vector3d(10, 1, 2));
}

TEST(PlyReaderTest, DropsNanPointsOfACloudOnly) {
  const std::string cloud =
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
      "property float z\nend_header\nnan nan nan\n1 2 3\n";
  const auto geometry = ReadPly(cloud, {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.vertices.cols(), 1);
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "1 0 0", "nan 0 0"), {}), "vertex 1 (from 0) is not");
  EXPECT_INVALID(ReadPly(Replaced(cloud, "nan nan nan", "inf 0 0"), {}), "is not finite: inf 0 0");
}

TEST(PlyReaderTest, SaysWhatIsWrongWithAHeader) {
  EXPECT_INVALID(ReadPly("\x89PNG\r\n", {}), "line 1 is \"\\211PNG\"; expected ply");
  EXPECT_INVALID(ReadPly("ply\nformat ascii 1.0\n", {}), "no end_header");
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "ascii", "utf8"), {}), "line 2");
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "property float x", "float x"), {}), "line 5 is");
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "float x", "quaternion x"), {}), "line 5 is");
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "vertex 3", "vertex -3"), {}), "line 4 is");
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "float z", "float w"), {}),
                 "lacks a property x, y or z");
}

TEST(PlyReaderTest, SaysWhereTheBodyIsWrong) {
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "3 0 1 2", "3 0 1 3"), {}),
                 "names vertex 3 (from 0) of 3");
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "3 0 1 2", "3 0 1 -1"), {}), "names vertex -1");
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "3 0 1 2", "3 0 1"), {}), "face 0 (from 0) of 1");
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "1 0 0", "1 zero 0"), {}), "line 12 is \"zero\"");
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "3 0 1 2", "1e9 0 1 2"), {}), "claims 1e+09 entries");
}

TEST(PlyReaderTest, RefusesClaimsBeforeItTakesMemory) {
  EXPECT_INVALID(ReadPly(Replaced(kTriangle, "vertex 3", "vertex 40000000"), {}),
                 "cannot hold them");
  EXPECT_INVALID(ReadPly("ply\nformat ascii 1.0\nelement nothing 9000000000\nend_header\n", {}),
                 "no properties");
  ReadLimits limits;
  limits.max_vertices = 2;
  EXPECT_EQ(ReadPly(kTriangle, limits).status().code(), absl::StatusCode::kResourceExhausted);
}

}  // namespace
}  // namespace cagefit::client
