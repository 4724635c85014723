#include "client/commands/fit_takes.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temp_folder.h"

namespace cagefit::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class ListTakesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    for (const char* take : {"a/take10", "a/take9", "b/take9", "a/walk.v2"}) {
      std::filesystem::create_directories(folder_ + take);
    }
    std::ofstream(folder_ + "still.ply") << "x";
    arguments_.out = "out";
  }

  std::vector<std::string> Names() const {
    const auto takes = ListTakes(arguments_);
    EXPECT_TRUE(takes.ok()) << takes.status();
    std::vector<std::string> names;
    for (const Take& take : *takes) names.push_back(take.name);
    return names;
  }

  const std::string folder_ = cagefit::testing::TempFolder() + "list_takes/";
  FitArguments arguments_;
};

TEST_F(ListTakesTest, AreInNaturalOrderOfTheNamesOfFoldersAndFiles) {
  arguments_.inputs = {folder_ + "a/take10/", folder_ + "still.ply", folder_ + "a/walk.v2",
                       folder_ + "a/take9"};
  EXPECT_THAT(Names(), ElementsAre("still", "take9", "take10", "walk.v2"));
}

TEST_F(ListTakesTest, EachHasItsOwnInputFolderAndPaths) {
  arguments_.inputs = {folder_ + "a/take9"};
  arguments_.cage = "cages/{take}.obj";
  arguments_.truth = {"truth/{take}/{take}.obj"};
  const auto takes = ListTakes(arguments_);
  ASSERT_TRUE(takes.ok()) << takes.status();
  const FitArguments& a = takes->front().arguments;
  EXPECT_THAT(a.inputs, ElementsAre(folder_ + "a/take9"));
  EXPECT_EQ(a.out, "out/take9");
  EXPECT_EQ(a.cage, "cages/take9.obj");
  EXPECT_THAT(a.truth, ElementsAre("truth/take9/take9.obj"));
}

TEST_F(ListTakesTest, AChunkIsEveryNth) {
  arguments_.inputs = {folder_ + "a/take9", folder_ + "a/take10", folder_ + "a/walk.v2",
                       folder_ + "still.ply"};
  arguments_.chunks = 3;
  EXPECT_THAT(Names(), ElementsAre("still", "walk.v2"));
  arguments_.chunk = 2;
  EXPECT_THAT(Names(), ElementsAre("take10"));
  arguments_.chunks = 9;
  arguments_.chunk = 8;
  EXPECT_THAT(Names(), ElementsAre());
}

TEST_F(ListTakesTest, TwoOfOneNameAndWhatIsNotThereAreRefused) {
  arguments_.inputs = {folder_ + "a/take9", folder_ + "b/take9"};
  const absl::Status twice = ListTakes(arguments_).status();
  EXPECT_TRUE(absl::IsInvalidArgument(twice));
  EXPECT_THAT(twice.message(), HasSubstr("a/take9 and " + folder_ + "b/take9"));
  arguments_.inputs = {folder_ + "nowhere"};
  EXPECT_TRUE(absl::IsNotFound(ListTakes(arguments_).status()));
}

}  // namespace
}  // namespace cagefit::client
