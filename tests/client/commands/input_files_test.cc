#include "client/commands/input_files.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Folder(const std::string& name, const std::vector<std::string>& files) {
  const std::string folder = cagefit::testing::TempFolder() + name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder + "/inner");
  for (const std::string& file : files) std::ofstream(folder + "/" + file) << "x";
  return folder;
}

TEST(NaturalLessTest, NumbersCompareAsNumbers) {
  EXPECT_TRUE(NaturalLess("frame_9.ply", "frame_10.ply"));
  EXPECT_FALSE(NaturalLess("frame_10.ply", "frame_9.ply"));
  EXPECT_TRUE(NaturalLess("a2b10", "a2b11"));
  EXPECT_TRUE(NaturalLess("a2", "b1"));
  EXPECT_TRUE(NaturalLess("frame_99999999999999999998", "frame_99999999999999999999"));
  EXPECT_TRUE(NaturalLess("a", "ab"));
  EXPECT_FALSE(NaturalLess("same_7", "same_7"));
  EXPECT_NE(NaturalLess("a01", "a1"), NaturalLess("a1", "a01"));
}

TEST(ListInputsTest, AFolderIsASequenceInNaturalOrder) {
  const std::string folder =
      Folder("natural", {"f10.ply", "f9.ply", "notes.txt", ".hidden.ply", "inner/f1.ply"});
  const auto files = ListInputs({folder});
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_THAT(*files, ElementsAre(folder + "/f9.ply", folder + "/f10.ply"));
}

TEST(ListInputsTest, FilesStayInTheirOrder) {
  const std::string folder = Folder("given", {"b.obj", "a.ply"});
  const auto files = ListInputs({folder + "/b.obj", folder + "/a.ply"});
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_THAT(*files, ElementsAre(folder + "/b.obj", folder + "/a.ply"));
}

TEST(ListInputsTest, SaysWhatIsWrong) {
  const std::string mixed = Folder("mixed", {"a.ply", "a.obj"}), empty = Folder("empty", {"x.txt"});
  EXPECT_EQ(ListInputs({"/nowhere"}).status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(ListInputs({mixed}).status().message()),
              HasSubstr("files of several formats (.obj, .ply)"));
  EXPECT_THAT(std::string(ListInputs({empty}).status().message()), HasSubstr("no .ply"));
  EXPECT_THAT(std::string(ListInputs({empty + "/x.txt"}).status().message()),
              HasSubstr("ends with \".txt\""));
}

}  // namespace
}  // namespace cagefit::client
