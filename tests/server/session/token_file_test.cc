#include "server/session/token_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "absl/strings/escaping.h"
#include "absl/time/clock.h"
#include "core/base/private_folder.h"

namespace cagefit::server {
namespace {

using ::testing::HasSubstr;

std::string Line(const std::string& name, const std::string& token) {
  const Digest digest = Sha256(token);
  return name + " " +
         absl::BytesToHexString(
             absl::string_view(reinterpret_cast<const char*>(digest.data()), digest.size())) +
         "\n";
}

class TokenFileTest : public ::testing::Test {
 protected:
  void Write(const std::string& text) {
    std::ofstream(path_ + ".new") << text;
    std::filesystem::rename(path_ + ".new", path_);
  }
  absl::StatusOr<std::unique_ptr<TokenFile>> Open() {
    return TokenFile::Open(path_, absl::Milliseconds(2),
                           [this](const absl::Status& status, size_t) {
                             std::lock_guard<std::mutex> lock(mutex_);
                             reloaded_.push_back(status);
                             changed_.notify_all();
                           });
  }
  absl::Status NextReload() {
    std::unique_lock<std::mutex> lock(mutex_);
    if (!changed_.wait_for(lock, std::chrono::seconds(20), [this] { return !reloaded_.empty(); })) {
      return absl::DeadlineExceededError("nothing was reloaded");
    }
    const absl::Status next = reloaded_.front();
    reloaded_.erase(reloaded_.begin());
    return next;
  }

  PrivateFolder folder_ = PrivateFolder::Create().value();
  const std::string path_ = folder_.path() + "/tokens";
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<absl::Status> reloaded_;
};

TEST_F(TokenFileTest, NewTokensAreInForceOnceTheyAreReloaded) {
  Write(Line("north", "a"));
  const auto file = Open();
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_NE((*file)->Find("a", absl::Now()), nullptr);
  Write(Line("north", "b"));
  EXPECT_EQ(NextReload(), absl::OkStatus());
  EXPECT_EQ((*file)->Find("a", absl::Now()), nullptr);
  EXPECT_NE((*file)->Find("b", absl::Now()), nullptr);
}

TEST_F(TokenFileTest, ABrokenOrMissingFileLeavesTheOldTokensInForce) {
  Write(Line("north", "a"));
  const auto file = Open();
  ASSERT_TRUE(file.ok()) << file.status();
  const auto before = (*file)->Find("a", absl::Now());
  Write("north nonsense\n");
  const absl::Status broken = NextReload();
  EXPECT_TRUE(absl::IsInvalidArgument(broken)) << broken;
  EXPECT_THAT(std::string(broken.message()), HasSubstr(path_ + ":1: "));
  EXPECT_EQ((*file)->Find("a", absl::Now()), before);
  std::filesystem::remove(path_);
  EXPECT_TRUE(absl::IsFailedPrecondition(NextReload()));
  EXPECT_EQ((*file)->Find("a", absl::Now()), before);
  Write(Line("north", "b"));
  EXPECT_EQ(NextReload(), absl::OkStatus());
  EXPECT_NE((*file)->Find("b", absl::Now()), nullptr);
}

TEST_F(TokenFileTest, AFileThatIsBrokenFromTheStartIsAnError) {
  EXPECT_TRUE(absl::IsFailedPrecondition(Open().status()));
  Write("north\n");
  EXPECT_TRUE(absl::IsInvalidArgument(Open().status()));
}

}  // namespace
}  // namespace cagefit::server
