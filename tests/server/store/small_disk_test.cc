// A store on a real disk that is full, or turns read-only.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>

#include "absl/time/clock.h"
#include "tests/server/store/store_fixture.h"

namespace cagefit::server {
namespace {

using testing::ReasonOf;
using testing::RecordOf;
using testing::RejectedAnswer;

class SmallDiskTest : public ::testing::Test {
 protected:
  void SetUp() override {
    // Mounts of this thread alone.
    const bool mounted = unshare(CLONE_FS | CLONE_NEWNS) == 0 &&
                         mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
                         mount("disk", folder_.path().c_str(), "tmpfs", 0, "size=16m") == 0;
    if (!mounted) {
      GTEST_SKIP() << "no right to mount a disk; SqliteJournalTest has a full one without";
    }
    journal_ = testing::OpenFile(folder_.path() + "/sessions.db", &codec_);
    ASSERT_TRUE(journal_->Create(RecordOf("one")).ok());
    epoch_ = journal_->RaiseEpoch("one")->epoch;
  }
  ~SmallDiskTest() override {
    if (journal_ == nullptr) return;
    journal_.reset();
    umount(folder_.path().c_str());
  }

  absl::Status Append(uint64_t number) {
    return journal_->Append("one", epoch_, RejectedAnswer(number), nullptr);
  }
  void Remount(unsigned long flags, const char* options) {
    ASSERT_EQ(mount(nullptr, folder_.path().c_str(), nullptr, MS_REMOUNT | flags, options), 0);
  }
  absl::Status ProbeAgain() {
    absl::SleepFor(SqlJournal::kRetryInterval);
    return journal_->Probe();
  }
  // Everything that was stored is there, and it goes on behind it.
  void ExpectGoesOnAt(uint64_t number) {
    EXPECT_EQ(ProbeAgain(), absl::OkStatus());
    EXPECT_EQ(journal_->Load("one")->head.next_sequence_number, number);
    EXPECT_EQ(journal_->Outlines("one")->size(), number);
    EXPECT_EQ(Append(number), absl::OkStatus());
  }

  PrivateFolder folder_ = PrivateFolder::Create().value();
  ProtoRecordCodec codec_;
  std::unique_ptr<SqlJournal> journal_;
  uint64_t epoch_ = 0;
};

TEST_F(SmallDiskTest, AFullOneIsUnavailableKeepsWhatWasStoredAndPasses) {
  Remount(0, "size=512k");
  uint64_t stored = 0;
  absl::Status status = Append(0);
  while (status.ok() && stored < 10'000) status = Append(++stored);
  EXPECT_TRUE(absl::IsUnavailable(status)) << status;
  EXPECT_EQ(ReasonOf(status), "STORE_UNAVAILABLE");
  EXPECT_FALSE(ProbeAgain().ok());
  Remount(0, "size=16m");
  ExpectGoesOnAt(stored);
}

TEST_F(SmallDiskTest, AReadOnlyOneIsUnavailableAndPasses) {
  ASSERT_EQ(Append(0), absl::OkStatus());
  journal_.reset();  // nothing can be mounted so while a file is open for writing
  Remount(MS_RDONLY, "size=16m");
  journal_ = testing::OpenFile(folder_.path() + "/sessions.db", &codec_);
  EXPECT_TRUE(absl::IsUnavailable(Append(1)));
  EXPECT_FALSE(ProbeAgain().ok());
  Remount(0, "size=16m");
  ExpectGoesOnAt(1);
}

}  // namespace
}  // namespace cagefit::server
