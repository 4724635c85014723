#include "server/session/obj_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cagefit::server {
namespace {

using ::testing::HasSubstr;

constexpr char kVertices[] = "v 0 0 0\nv 1 0 0\nv 0 1.5 0\nv 0 0 -2e-1\n";
constexpr char kFaces[] = "f 1 2 3\nf 1 4 2\nf 2 4 3\nf 3 4 1\n";

std::string Tetrahedron() { return std::string(kVertices) + kFaces; }

// The message for a file that must be refused.
std::string ErrorOf(const std::string& text, int32_t max_vertices = 100) {
  const auto mesh = ReadTemplateObj(text, max_vertices);
  EXPECT_TRUE(absl::IsInvalidArgument(mesh.status())) << mesh.status();
  return std::string(mesh.status().message());
}

TEST(ObjReaderTest, ReadsVerticesAndTriangles) {
  const auto mesh = ReadTemplateObj(Tetrahedron(), 4);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  Points3d vertices(3, 4);
  vertices << 0, 1, 0, 0,  //
      0, 0, 1.5, 0,        //
      0, 0, 0, -0.2;
  Triangles triangles(3, 4);
  triangles << 0, 0, 1, 2,  //
      1, 3, 3, 3,           //
      2, 1, 2, 0;
  EXPECT_EQ(mesh->vertices(), vertices);
  EXPECT_EQ(mesh->triangles(), triangles);
}

TEST(ObjReaderTest, KeepsCreasesAndCorners) {
  const auto mesh =
      ReadTemplateObj("# cagefit crease 1 3\n# cagefit corner 4\n" + Tetrahedron(), 4);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  ASSERT_EQ(mesh->tags().edges.size(), 1u);
  EXPECT_THAT(mesh->tags().edges[0], ::testing::ElementsAre(0, 2));
  EXPECT_THAT(mesh->tags().corners, ::testing::ElementsAre(3));
}

TEST(ObjReaderTest, SkipsCommentsBlankLinesAndCarriageReturns) {
  EXPECT_TRUE(
      ReadTemplateObj("# a cage\r\n\r\n" + std::string(kVertices) + "  \n" + kFaces + "# end", 4)
          .ok());
}

TEST(ObjReaderTest, ReadsCreasesAndCorners) {
  const auto mesh = ReadTemplateObj(
      "# cagefit crease 1 2\n# cagefit crease 4 2\n# cagefit corner 3\n" + Tetrahedron(), 4);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  const std::vector<std::array<int32_t, 2>> edges = {{0, 1}, {3, 1}};
  EXPECT_EQ(mesh->tags().edges, edges);
  EXPECT_EQ(mesh->tags().corners, std::vector<int32_t>{2});
}

TEST(ObjReaderTest, RefusesTagsThatNameNothing) {
  for (const char* line : {"# cagefit crease 1", "# cagefit crease 0 1", "# cagefit corner x",
                           "# cagefit corner 1 2", "# cagefit seam 1 2"}) {
    EXPECT_THAT(ErrorOf(std::string(line) + "\n" + Tetrahedron()), HasSubstr("line 1")) << line;
  }
  EXPECT_THAT(ErrorOf("# cagefit corner 5\n" + Tetrahedron()), HasSubstr("corner 4 is outside"));
}

TEST(ObjReaderTest, NamesTheLineThatItDoesNotKnow) {
  for (const char* line : {"vn 0 0 1", "v 1 2", "v 1 2 3 4", "v 1 2 x", "f 1 2", "f 1 2 3 4",
                           "f 1/1 2/2 3/3", "f 0 1 2", "f -1 1 2", "f 1.5 2 3", "garbage",
                           "# cagefit crease 1", "# cagefit crease 1 x", "# cagefit corner 0"}) {
    EXPECT_THAT(ErrorOf(std::string(kVertices) + line + "\n" + kFaces), HasSubstr("line 5"))
        << line;
  }
}

TEST(ObjReaderTest, QuotesOnlyTheBeginningOfALongLine) {
  EXPECT_LT(ErrorOf(std::string(1'000'000, 'x')).size(), 200u);
}

TEST(ObjReaderTest, RefusesMoreVerticesThanAllowed) {
  EXPECT_THAT(ErrorOf(Tetrahedron(), 3), HasSubstr("more than 3 vertices"));
}

TEST(ObjReaderTest, RefusesWhatIsNoControlMesh) {
  ErrorOf("");
  ErrorOf(std::string(kVertices) + "f 1 2 9\n");
  ErrorOf("v nan 0 0\n" + Tetrahedron());
  ErrorOf(Tetrahedron() + "# cagefit corner 5\n");
  ErrorOf(Tetrahedron() + "f 1 2 3\n");  // an edge with three triangles
}

}  // namespace
}  // namespace cagefit::server
