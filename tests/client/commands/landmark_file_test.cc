#include "client/commands/landmark_file.h"

#include <gmock/gmock.h>

#include <fstream>

#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

std::string File(const std::string& text) {
  const std::string path = cagefit::testing::TempFolder() + "landmarks.txt";
  std::ofstream(path) << text;
  return path;
}

TEST(LandmarkFileTest, ReadsPlacesOfEveryFrame) {
  const auto read = ReadLandmarks(File("# the nose\n"
                                       "f9 vertex 7 1 -2.5 3e1\n"
                                       "\n"
                                       "f11 surface 40 0.25 0.5 1 2 3\r\n"
                                       "f9 vertex 8 0 0 0"),
                                  {"in/f9.ply", "in/f10.drc", "in/f11.ply"});
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 3u);
  ASSERT_EQ((*read)[0].size(), 2u);
  EXPECT_EQ((*read)[0][0].vertex(), 7u);
  EXPECT_EQ((*read)[0][0].x(), 1);
  EXPECT_EQ((*read)[0][0].y(), -2.5);
  EXPECT_EQ((*read)[0][0].z(), 30);
  EXPECT_EQ((*read)[0][1].vertex(), 8u);
  EXPECT_TRUE((*read)[1].empty());
  ASSERT_EQ((*read)[2].size(), 1u);
  EXPECT_EQ((*read)[2][0].surface().triangle(), 40u);
  EXPECT_EQ((*read)[2][0].surface().u(), 0.25);
  EXPECT_EQ((*read)[2][0].surface().v(), 0.5);
  EXPECT_EQ((*read)[2][0].z(), 3);
}

TEST(LandmarkFileTest, SaysWhatIsWrongAndWhere) {
  const auto message_of = [](const std::string& text) {
    const absl::Status status = ReadLandmarks(File(text), {"a/f.ply"}).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    const std::string message(status.message());
    return message.substr(message.find(": ") + 2);
  };
  EXPECT_EQ(message_of("f vertex 1 0 0 0\ng vertex 1 0 0 0"),
            "line 2: the frame is \"g\"; expected the name of an input file without its ending");
  EXPECT_EQ(message_of("f point 1 0 0 0"),
            "line 1: the second word is \"point\"; expected vertex or surface");
  EXPECT_EQ(message_of("f"), "line 1: the second word is \"\"; expected vertex or surface");
  EXPECT_EQ(message_of("f vertex 1 0 0"),
            "line 1: the number of words is \"5\"; expected 6, FRAME vertex INDEX X Y Z");
  EXPECT_EQ(message_of("f surface 1 0 0 0 0"),
            "line 1: the number of words is \"7\"; expected 8, FRAME surface TRIANGLE U V X Y Z");
  EXPECT_EQ(message_of("f vertex -1 0 0 0"),
            "line 1: the vertex is \"-1\"; expected 0 to 2147483647");
  EXPECT_EQ(message_of("f vertex 1 0 nan 0"), "line 1: Y is \"nan\"; expected a finite number");
  EXPECT_TRUE(absl::IsNotFound(ReadLandmarks("/nowhere.txt", {"f.ply"}).status()));
  const auto twice = ReadLandmarks(File(""), {"a/f.ply", "b/f.ply"}).status();
  EXPECT_THAT(std::string(twice.message()), ::testing::HasSubstr("b/f.ply: has the name of"));
}

}  // namespace
}  // namespace cagefit::client
