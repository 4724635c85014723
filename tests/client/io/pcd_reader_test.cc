#include <cmath>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "client/io/format_readers.h"
#include "tests/client/io/expect_error.h"

namespace cagefit::client {
namespace {

std::string Header(int points, const std::string& data) {
  return absl::StrCat(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS _ x y z\nSIZE 1 4 4 4\nTYPE U F F F\nCOUNT 2 1 1 1\n",
      "WIDTH ", points, "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS ", points, "\nDATA ", data,
      "\n");
}

std::string Floats(std::initializer_list<float> values) {
  return std::string(reinterpret_cast<const char*>(values.begin()), 4 * values.size());
}

TEST(PcdReaderTest, ReadsText) {
  const auto geometry = ReadPcd(Header(2, "ascii") + "0 0 1 2 3\n0 0 nan nan nan\n", {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  ASSERT_EQ(geometry->mesh.vertices.cols(), 1);
  EXPECT_EQ(geometry->mesh.vertices.col(0), Eigen::Vector3d(1, 2, 3));
}

TEST(PcdReaderTest, ReadsBinaryRows) {
  const auto geometry =
      ReadPcd(Header(2, "binary") + "__" + Floats({1, 2, 3}) + "__" + Floats({4, 5, 6}), {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.vertices.col(1), Eigen::Vector3d(4, 5, 6));
}

TEST(PcdReaderTest, ReadsCompressedFields) {
  const std::string fields = "____" + Floats({1, 4}) + Floats({2, 5}) + Floats({3, 6});
  const uint32_t sizes[2] = {static_cast<uint32_t>(fields.size() + 1),
                             static_cast<uint32_t>(fields.size())};
  std::string bytes = Header(2, "binary_compressed");
  bytes.append(reinterpret_cast<const char*>(sizes), 8);
  bytes.push_back(static_cast<char>(fields.size() - 1));  // one literal run
  const auto geometry = ReadPcd(bytes + fields, {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.vertices.col(1), Eigen::Vector3d(4, 5, 6));
  EXPECT_INVALID(ReadPcd(bytes + fields.substr(1), {}), "compressed bytes");
}

TEST(PcdReaderTest, ReadsNormals) {
  const auto geometry = ReadPcd(
      "FIELDS x y z normal_x normal_y normal_z curvature\nSIZE 4 4 4 4 4 4 4\nTYPE F F F F F F F\n"
      "WIDTH 1\nHEIGHT 1\nDATA ascii\n1 2 3 0 1 0 0.5\n",
      {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->normals.col(0), Eigen::Vector3f(0, 1, 0));
}

TEST(PcdReaderTest, SaysWhatIsWrong) {
  EXPECT_INVALID(ReadPcd("ply\n", {}), "line 1 is \"ply\"; expected a PCD header");
  EXPECT_INVALID(ReadPcd("VERSION 0.7\n", {}), "no DATA");
  EXPECT_INVALID(ReadPcd("FIELDS x\nSIZE 4\nTYPE F\nPOINTS 1\nDATA ascii\n", {}), "no PCD field y");
  EXPECT_INVALID(ReadPcd(Header(2, "ascii") + "0 0 1 2 3\n", {}), "ends at point 1 (from 0) of 2");
  EXPECT_INVALID(ReadPcd(Header(1, "ascii") + "0 0 1 2\n", {}), "line 12 is");
  EXPECT_INVALID(ReadPcd(Header(40'000'000, "binary") + "xx", {}), "ends at point 0");
  EXPECT_INVALID(ReadPcd(Header(1, "zip"), {}), "DATA is not");
  EXPECT_INVALID(ReadPcd(Header(1, "binary_compressed") + "12", {}), "ends after DATA");
}

}  // namespace
}  // namespace cagefit::client
