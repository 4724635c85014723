#include "client/commands/mask_files.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::HasSubstr;

std::string Folder(const std::string& name, const std::vector<std::string>& files) {
  const std::string folder = cagefit::testing::TempFolder() + name;
  std::filesystem::remove_all(folder);
  for (const std::string& file : files) {
    const std::filesystem::path path = folder + "/" + file;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path) << file;
  }
  return folder;
}

void ExpectError(const std::string& folder, const std::vector<std::string>& frames,
                 const std::string& text) {
  const absl::Status status = ListMasks(folder, {"left", "right"}, frames).status();
  EXPECT_FALSE(status.ok());
  EXPECT_THAT(std::string(status.message()), HasSubstr(text));
}

TEST(MaskFilesTest, FindsTheMasksOfEveryFrame) {
  const std::string folder = Folder("masks", {"left/f9.png", "right/f9.png", "right/f10.png",
                                              "rig/top/f10.png", "notes.txt", ".git/x"});
  const auto masks =
      ListMasks(folder, {"right", "left", "rig/top"}, {"in/f9.ply", "in/f10.drc", "in/f11.ply"});
  ASSERT_TRUE(masks.ok()) << masks.status();
  ASSERT_EQ(masks->size(), 3u);
  ASSERT_EQ((*masks)[0].size(), 2u);
  EXPECT_EQ((*masks)[0][0].camera, "right");
  EXPECT_EQ((*masks)[0][1].path, folder + "/left/f9.png");
  ASSERT_EQ((*masks)[1].size(), 2u);
  EXPECT_EQ((*masks)[1][1].camera, "rig/top");
  EXPECT_TRUE((*masks)[2].empty());
  const auto read = ReadMasks((*masks)[0]);
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ((*read)[1].camera, "left");
  EXPECT_EQ((*read)[1].png, "left/f9.png");
}

TEST(MaskFilesTest, SaysWhatIsWrong) {
  ExpectError("/nowhere", {"f.ply"}, "/nowhere: there is no such folder");
  ExpectError(Folder("unknown", {"left/f.png", "front/f.png"}), {"f.ply"},
              "front: no camera is named \"front\"");
  ExpectError(Folder("other", {"left/g.png"}), {"f.ply"}, "/CAMERA/f.png");
  ExpectError(Folder("same", {"left/f.png"}), {"a/f.ply", "b/f.ply"}, "b/f.ply: has the name of");
  EXPECT_FALSE(ReadMasks({{"left", "/nowhere/f.png"}}).ok());
}

}  // namespace
}  // namespace cagefit::client
