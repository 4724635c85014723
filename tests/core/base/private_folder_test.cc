#include "core/base/private_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>

namespace cagefit {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// Sets TMPDIR for the length of a test.
class TemporaryParent {
 public:
  explicit TemporaryParent(const std::string& path) {
    if (const char* value = getenv("TMPDIR")) before_ = value;
    setenv("TMPDIR", path.c_str(), 1);
  }
  ~TemporaryParent() {
    before_.has_value() ? setenv("TMPDIR", before_->c_str(), 1) : unsetenv("TMPDIR");
  }

 private:
  std::optional<std::string> before_;
};

TEST(PrivateFolderTest, OnlyItsUserMayEnter) {
  const auto folder = PrivateFolder::Create();
  ASSERT_TRUE(folder.ok()) << folder.status();
  struct stat info;
  ASSERT_EQ(stat(folder->path().c_str(), &info), 0);
  EXPECT_TRUE(S_ISDIR(info.st_mode));
  EXPECT_EQ(info.st_mode & 0777, 0700u);
}

TEST(PrivateFolderTest, GoesWithEverythingInIt) {
  std::string path;
  {
    const auto folder = PrivateFolder::Create();
    ASSERT_TRUE(folder.ok()) << folder.status();
    path = folder->path();
    std::filesystem::create_directories(path + "/a/b");
    std::ofstream(path + "/a/b/file") << "text";
    ASSERT_TRUE(std::filesystem::exists(path + "/a/b/file"));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(PrivateFolderTest, MovesWithItsOwner) {
  auto folder = PrivateFolder::Create();
  ASSERT_TRUE(folder.ok()) << folder.status();
  const std::string path = folder->path();
  {
    const PrivateFolder moved = *std::move(folder);
    EXPECT_EQ(moved.path(), path);
    folder = absl::CancelledError();  // destroys what was moved from
    EXPECT_TRUE(std::filesystem::exists(path));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(PrivateFolderTest, LiesInTheFolderForTemporaryFiles) {
  const auto parent = PrivateFolder::Create();
  ASSERT_TRUE(parent.ok()) << parent.status();
  const TemporaryParent temporary(parent->path());
  const auto folder = PrivateFolder::Create();
  ASSERT_TRUE(folder.ok()) << folder.status();
  EXPECT_THAT(folder->path(), StartsWith(parent->path() + "/"));
}

TEST(PrivateFolderTest, NamesThePathThatCannotBeMade) {
  const TemporaryParent temporary("/nowhere/at/all");
  const auto folder = PrivateFolder::Create();
  EXPECT_TRUE(absl::IsInternal(folder.status())) << folder.status();
  EXPECT_THAT(folder.status().message(), HasSubstr("/nowhere/at/all"));
}

}  // namespace
}  // namespace cagefit
