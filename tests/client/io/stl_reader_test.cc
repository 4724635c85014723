#include <cmath>
#include <cstring>

#include "client/io/format_readers.h"
#include "tests/client/io/expect_error.h"

namespace cagefit::client {
namespace {

constexpr char kText[] =
    "solid two\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    "endfacet\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex -0 1 0\nendloop\n"
    "endfacet\nendsolid two\n";

std::string Binary(uint32_t claimed, const std::vector<float>& corners) {
  std::string bytes(80, 's');
  bytes.append(reinterpret_cast<const char*>(&claimed), 4);
  for (size_t f = 0; f + 9 <= corners.size(); f += 9) {
    bytes.append(12, '\0');
    bytes.append(reinterpret_cast<const char*>(&corners[f]), 36);
    bytes.append(2, '\0');
  }
  return bytes;
}

TEST(StlReaderTest, JoinsCornersAtOnePosition) {
  const auto geometry = ReadStl(kText, {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.vertices.cols(), 4);
  EXPECT_EQ(geometry->mesh.triangles.col(1), Eigen::Vector3i(1, 3, 2));
}

TEST(StlReaderTest, ReadsBinaryEvenIfItCallsItselfSolid) {
  std::string bytes = Binary(1, {0, 0, 0, 1, 0, 0, 0, 1, 0});
  bytes.replace(0, 5, "solid");
  const auto geometry = ReadStl(bytes, {});
  ASSERT_TRUE(geometry.ok()) << geometry.status();
  EXPECT_EQ(geometry->mesh.vertices.col(2), Eigen::Vector3d(0, 1, 0));
}

TEST(StlReaderTest, SaysWhatIsWrong) {
  EXPECT_INVALID(ReadStl("solid", {}), "neither text STL");
  EXPECT_INVALID(ReadStl(Binary(1000, {0, 0, 0, 1, 0, 0, 0, 1, 0}), {}), "claims 1000 triangles");
  EXPECT_INVALID(ReadStl(Binary(1, {0, 0, NAN, 1, 0, 0, 0, 1, 0}), {}), "triangle 0 (from 0)");
  EXPECT_INVALID(ReadStl("solid x\nfacet\nvertex 1 2\n", {}), "line 3 is \"vertex 1 2\"");
  EXPECT_INVALID(ReadStl("solid x\nfacet\nvertex 1 2 3\nendfacet\n", {}), "three vertices before");
  EXPECT_INVALID(ReadStl("solid x\nfacet\nvertex 1 2 3\n", {}), "inside a facet");
  EXPECT_INVALID(ReadStl("solid facet\n", {}), "no vertices");
}

}  // namespace
}  // namespace cagefit::client
