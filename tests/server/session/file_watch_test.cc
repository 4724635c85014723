#include "server/session/file_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <future>

#include "core/base/private_folder.h"

namespace cagefit::server {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr absl::Duration kPoll = absl::Milliseconds(2);

class FileWatchTest : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_.path() + "/" + name; }
  void Write(const std::string& name, const std::string& text) {
    // At once: a watch may look at any moment.
    std::ofstream(Path("new")) << text;
    std::filesystem::rename(Path("new"), Path(name));
  }
  FileWatch::ChangedFn Push() {
    return [this](const FileContents& contents) {
      std::lock_guard<std::mutex> lock(mutex_);
      seen_.push_back(contents);
      changed_.notify_all();
    };
  }
  FileContents Next() {
    std::unique_lock<std::mutex> lock(mutex_);
    if (!changed_.wait_for(lock, std::chrono::seconds(20), [this] { return !seen_.empty(); })) {
      return absl::DeadlineExceededError("nothing changed");
    }
    FileContents next = std::move(seen_.front());
    seen_.erase(seen_.begin());
    return next;
  }

  PrivateFolder folder_ = PrivateFolder::Create().value();
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<FileContents> seen_;
};

TEST_F(FileWatchTest, TellsNewContentsOfAllFiles) {
  Write("a", "1");
  Write("b", "2");
  const std::vector<std::string> paths = {Path("a"), Path("b")};
  const FileWatch watch(paths, ReadFiles(paths), kPoll, Push());
  Write("b", "3");
  const FileContents seen = Next();
  ASSERT_TRUE(seen.ok()) << seen.status();
  EXPECT_THAT(*seen, ElementsAre("1", "3"));
}

TEST_F(FileWatchTest, ContentsThatStayTheSameAreNoChange) {
  Write("a", "1");
  const FileWatch watch({Path("a")}, ReadFiles({Path("a")}), kPoll, Push());
  Write("a", "1");
  Write("a", "2");
  const FileContents seen = Next();
  ASSERT_TRUE(seen.ok()) << seen.status();
  EXPECT_THAT(*seen, ElementsAre("2"));
}

TEST_F(FileWatchTest, FollowsALinkThatIsTurned) {
  Write("a", "1");
  Write("b", "2");
  std::filesystem::create_symlink(Path("a"), Path("link"));
  const FileWatch watch({Path("link")}, ReadFiles({Path("link")}), kPoll, Push());
  std::filesystem::create_symlink(Path("b"), Path("link2"));
  std::filesystem::rename(Path("link2"), Path("link"));
  const FileContents seen = Next();
  ASSERT_TRUE(seen.ok()) << seen.status();
  EXPECT_THAT(*seen, ElementsAre("2"));
}

TEST_F(FileWatchTest, AFileThatGoesIsToldOnceAndItsReturnToo) {
  Write("a", "1");
  const FileWatch watch({Path("a")}, ReadFiles({Path("a")}), kPoll, Push());
  std::filesystem::remove(Path("a"));
  EXPECT_TRUE(absl::IsFailedPrecondition(Next().status()));
  Write("a", "1");
  const FileContents seen = Next();
  ASSERT_TRUE(seen.ok()) << seen.status();
  EXPECT_THAT(*seen, ElementsAre("1"));
}

TEST_F(FileWatchTest, FilesThatCannotBeReadAreNamed) {
  ASSERT_EQ(mkfifo(Path("pipe").c_str(), 0600), 0);
  for (const std::string& path : {Path("none"), Path("pipe"), folder_.path()}) {
    const absl::Status status = ReadFiles({path}).status();
    EXPECT_TRUE(absl::IsFailedPrecondition(status)) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(path));
  }
  Write("large", std::string((1 << 20) + 1, 'x'));
  EXPECT_THAT(std::string(ReadFiles({Path("large")}).status().message()),
              HasSubstr("larger than 1 MiB"));
  Write("just", std::string(1 << 20, 'x'));
  EXPECT_TRUE(ReadFiles({Path("just")}).ok());
}

}  // namespace
}  // namespace cagefit::server
