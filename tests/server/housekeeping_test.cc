#include "server/housekeeping.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>

#include "server/log.h"
#include "tests/server/store/store_fixture.h"

namespace cagefit::server {
namespace {

using testing::CageConfig;

// What housekeeping says of its journal, one look after another.
class Looks {
 public:
  void Take(const absl::Status& status) {
    std::lock_guard<std::mutex> lock(mutex_);
    last_ = status;
    ++count_;
    changed_.notify_all();
  }
  // Whether the journal is seen to be so within some seconds, from now on.
  bool Become(bool ok) {
    std::unique_lock<std::mutex> lock(mutex_);
    const int seen = count_;
    return changed_.wait_for(lock, std::chrono::seconds(20),
                             [&] { return count_ > seen && last_.ok() == ok; });
  }
  void WaitForAnother() {
    std::unique_lock<std::mutex> lock(mutex_);
    const int seen = count_;
    changed_.wait(lock, [&] { return count_ > seen + 1; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  absl::Status last_;
  int count_ = 0;
};

class HousekeepingTest : public ::testing::Test {
 protected:
  void Keep(absl::Duration unload_after, absl::Duration time_to_live) {
    const Housekeeping::Options options = {absl::Milliseconds(5), unload_after, time_to_live};
    keeper_.emplace(
        options, journal_.get(), &store_, [this](const absl::Status& s) { looks_.Take(s); },
        SilentLog());
  }

  testing::StoreFile file_;
  testing::FakeTemplates templates_;
  std::unique_ptr<SqlJournal> journal_ = file_.Open();
  SessionStore store_{SessionStore::Limits(), journal_.get(), &templates_, testing::NoTime};
  Looks looks_;
  std::optional<Housekeeping> keeper_;
};

TEST_F(HousekeepingTest, SeesAStoreGoAwayAndComeBack) {
  Keep(absl::InfiniteDuration(), absl::InfiniteDuration());
  EXPECT_TRUE(looks_.Become(true));
  std::filesystem::rename(file_.path(), file_.path() + ".away");
  std::filesystem::create_directory(file_.path());
  EXPECT_TRUE(looks_.Become(false));
  std::filesystem::remove(file_.path());
  std::filesystem::rename(file_.path() + ".away", file_.path());
  EXPECT_TRUE(looks_.Become(true));
}

TEST_F(HousekeepingTest, DeletesSessionsAfterTheirTimeToLiveButNoneWithAStream) {
  const std::string unused = (*store_.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  const std::string streaming =
      (*store_.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  ASSERT_TRUE(store_.OpenStream(streaming, [](const absl::Status&) {}).ok());
  Keep(absl::InfiniteDuration(), absl::Milliseconds(20));
  while (store_.Find(unused).ok()) looks_.WaitForAnother();
  for (int look = 0; look < 10; ++look) looks_.WaitForAnother();
  EXPECT_TRUE(store_.Find(streaming).ok());
}

TEST_F(HousekeepingTest, TakesUnusedSessionsOutOfMemory) {
  const std::string id = (*store_.Create(Principal(), CageConfig(), absl::UnixEpoch()))->id();
  const std::weak_ptr<SessionLedger> loaded = store_.Find(id).value();
  Keep(absl::ZeroDuration(), absl::InfiniteDuration());
  while (!loaded.expired()) looks_.WaitForAnother();
  EXPECT_TRUE(store_.Find(id).ok());
}

}  // namespace
}  // namespace cagefit::server
